// SPDX-License-Identifier: Zlib
#pragma once

#include "limber/render/vec3.h"

#include <vector>

namespace limber::render {

/// A line drawn over the shapes: in full where it is in front of them, faintly where they hide it.
struct OverlayLine {
  Vec3 from, to;       ///< Metres.
  Vec3 colour;         ///< sRGB, 0 to 1.
  float width = 0.0f;  ///< Pixels; 0: DrawOptions::lineWidth.
};

using Overlay = std::vector<OverlayLine>;

/// Appends an arrow; its head is a fifth of it, as two strokes across `eye`'s line of sight.
void addArrow(Overlay& overlay, Vec3 from, Vec3 to, Vec3 colour, Vec3 eye, float width = 0.0f);

/// Appends three lines of length 2 x `size` that cross at `at`, along the axes.
void addCross(Overlay& overlay, Vec3 at, float size, Vec3 colour, float width = 0.0f);

/// sRGB colour of a share of a range, from dark blue (0) over green to yellow (1): perceptually even and
/// rising in lightness, so that it reads in grey as well. Shares outside are clamped.
Vec3 shareColour(float share);

}  // namespace limber::render
