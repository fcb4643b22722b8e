// SPDX-License-Identifier: Zlib
#pragma once

#include "pixel_area.h"

#include <cstdint>
#include <string>
#include <vector>

namespace limber::render {

// The chunks of an animated PNG (PNG Specification, Third Edition, 5.3 and 11.3.4), each whole: length,
// type, data and CRC.

/// All chunks of a PNG file before its pixels, with the signature, and its pixels as one zlib stream.
struct PngParts {
  std::vector<std::uint8_t> head;
  std::vector<std::uint8_t> pixels;
};
PngParts splitPng(const std::vector<std::uint8_t>& png);

/// acTL: an endless loop.
std::vector<std::uint8_t> animationControl(std::uint32_t frames);

/// fcTL: the frame that follows is laid over an area of the one before, and stays. Shown for numerator /
/// denominator s.
std::vector<std::uint8_t> frameControl(std::uint32_t sequence, const PixelArea& area,
                                       std::uint16_t delayNumerator, std::uint16_t delayDenominator);

/// IDAT, the first frame's pixels.
std::vector<std::uint8_t> firstFrame(const std::vector<std::uint8_t>& pixels);

/// fdAT, a later frame's pixels.
std::vector<std::uint8_t> laterFrame(std::uint32_t sequence, const std::vector<std::uint8_t>& pixels);

/// IEND.
std::vector<std::uint8_t> imageEnd();

}  // namespace limber::render
