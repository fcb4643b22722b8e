// SPDX-License-Identifier: Zlib
#pragma once

#include "limber/render/image.h"

#include <cstdint>
#include <string>
#include <vector>

namespace limber::render {

struct ApngFrame {
  std::uint32_t width, height, x, y;  // of the part that is new
  std::uint16_t delayNumerator, delayDenominator;
  Image shown;  // all of it, over what was there before
};

struct Apng {
  std::uint32_t plays = 0;
  std::vector<ApngFrame> frames;
};

/// A reader of its own, for tests. Throws std::runtime_error with what breaks the format: a CRC, an order, a
/// sequence number, a count, an area outside the picture.
Apng readApng(const std::string& path);

}  // namespace limber::render
