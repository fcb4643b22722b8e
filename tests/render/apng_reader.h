// SPDX-License-Identifier: Zlib
#pragma once

#include "limber/render/image.h"

#include <cstdint>
#include <string>
#include <vector>

namespace limber::render {

struct ApngFrame {
  std::uint32_t width, height, x, y;  // of the part that changes
  std::uint16_t delayNumerator, delayDenominator;
  Image shown;  // the whole picture after this frame
};

struct Apng {
  std::uint32_t plays = 0;
  std::vector<ApngFrame> frames;
};

/// Reads an animated PNG independently of the library, for tests. Throws std::runtime_error with the error in
/// the format: a CRC, an order, a sequence number, a count, an area outside the picture.
Apng readApng(const std::string& path);

}  // namespace limber::render
