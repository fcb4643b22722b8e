// SPDX-License-Identifier: Zlib
#pragma once

#include "limber/render/image.h"

#include <cstdint>
#include <string>
#include <vector>

namespace limber::render {

struct PngStyle {
  int level;    ///< Of zlib, 1 to 9.
  int filters;  ///< PNG_FILTER_NONE or more.
};

/// The bytes of a PNG file, RGBA in sRGB. Throws std::runtime_error with the path they are for and libpng's
/// reason.
std::vector<std::uint8_t> encodePng(const std::string& path, const Image& image, const PngStyle& style);

}  // namespace limber::render
