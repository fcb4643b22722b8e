// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/render/image.h>
#include <limber/render/vec3.h>

#include <string>
#include <vector>

namespace limber::demo {

struct LegendEntry {
  std::string text;     ///< small letters, digits and blanks; others are left blank
  render::Vec3 colour;  ///< sRGB
};

/// Writes the entries below each other into the upper left corner, each behind a square of its colour, in
/// letters of 1/48 of the picture's height or 7 pixels, whichever is larger.
void drawLegend(render::Image& image, const std::vector<LegendEntry>& entries);

}  // namespace limber::demo
