// SPDX-License-Identifier: Zlib
#pragma once

#include "limber/render/vec3.h"

#include <vector>

namespace limber::render {

/// A line drawn over the shapes: opaque in front of them, faint behind them.
struct OverlayLine {
  Vec3 from, to;       ///< Metres.
  Vec3 colour;         ///< sRGB, 0 to 1.
  float width = 0.0f;  ///< Pixels; 0: DrawOptions::lineWidth.
};

using Overlay = std::vector<OverlayLine>;

/// Appends an arrow. Its head is a fifth of its length: two strokes that spread across the line of sight from
/// `eye`.
void addArrow(Overlay& overlay, Vec3 from, Vec3 to, Vec3 colour, Vec3 eye, float width = 0.0f);

/// Appends three lines of length 2 x `size` along the axes; they cross at `at`.
void addCross(Overlay& overlay, Vec3 at, float size, Vec3 colour, float width = 0.0f);

/// Returns the sRGB colour of a fraction of a range, from dark blue (0) over green to yellow (1). Equal steps
/// look equal. The lightness rises, so the colours can be read in greyscale, too. Fractions outside 0 to 1
/// are clamped.
Vec3 shareColour(float share);

}  // namespace limber::render
