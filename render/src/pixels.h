// SPDX-License-Identifier: Zlib
#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

namespace limber::render {

/// sRGB and linear light, 0 to 1, by IEC 61966-2-1.
inline float srgbToLinear(float s) {
  return s <= 0.04045f ? s / 12.92f : std::pow((s + 0.055f) / 1.055f, 2.4f);
}
inline float linearToSrgb(float l) {
  return l <= 0.0031308f ? 12.92f * l : 1.055f * std::pow(l, 1.0f / 2.4f) - 0.055f;
}

/// A rectangle of an image's pixels; y counts from the top.
struct PixelArea {
  int x = 0;
  int y = 0;
  int width = 0;
  int height = 0;
};

/// Resamples an sRGB RGBA picture of `width` x `height` pixels in linear light to a square of `size`. Edges
/// wrap around, because the texture repeats. A picture of that size is only copied.
std::vector<std::uint8_t> resampleToSquare(int width, int height, const std::uint8_t* rgba, int size);

}  // namespace limber::render
