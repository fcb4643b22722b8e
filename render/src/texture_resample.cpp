// SPDX-License-Identifier: Zlib
#include "texture_resample.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "srgb.h"

namespace limber::render {
namespace {

using Pixel = std::array<float, 4>;

struct Tap {
  std::size_t source = 0;
  float weight = 0.0f;
};

std::size_t wrap(int i, int count) { return static_cast<std::size_t>(((i % count) + count) % count); }

// A tent as wide as one texel of the coarser of both pictures: bilinear when enlarging.
std::vector<Tap> tapsFor(int target, int targetCount, int sourceCount) {
  const float scale = static_cast<float>(sourceCount) / static_cast<float>(targetCount);
  const float reach = std::max(scale, 1.0f);
  const float centre = (static_cast<float>(target) + 0.5f) * scale - 0.5f;
  std::vector<Tap> taps;
  float sum = 0.0f;
  for (int i = static_cast<int>(std::ceil(centre - reach)); static_cast<float>(i) <= centre + reach; ++i) {
    const float weight = 1.0f - std::abs(static_cast<float>(i) - centre) / reach;
    if (weight > 0.0f) {
      taps.push_back({wrap(i, sourceCount), weight});
      sum += weight;
    }
  }
  for (Tap& tap : taps) {
    tap.weight /= sum;
  }
  return taps;
}

// Resamples rows to `newWidth` and transposes, so that doing it twice does both directions.
std::vector<Pixel> resampleTransposed(const std::vector<Pixel>& in, int width, int height, int newWidth) {
  const auto rows = static_cast<std::size_t>(height);
  std::vector<Pixel> out(static_cast<std::size_t>(newWidth) * rows, Pixel{});
  for (int x = 0; x < newWidth; ++x) {
    const std::vector<Tap> taps = tapsFor(x, newWidth, width);
    for (std::size_t y = 0; y < rows; ++y) {
      Pixel& sum = out[static_cast<std::size_t>(x) * rows + y];
      for (const Tap& tap : taps) {
        const Pixel& source = in[y * static_cast<std::size_t>(width) + tap.source];
        for (std::size_t c = 0; c < 4; ++c) {
          sum[c] += tap.weight * source[c];
        }
      }
    }
  }
  return out;
}

std::uint8_t toByte(float value) {
  return static_cast<std::uint8_t>(std::lround(255.0f * std::clamp(value, 0.0f, 1.0f)));
}

}  // namespace

std::vector<std::uint8_t> resampleToSquare(int width, int height, const std::uint8_t* rgba, int size) {
  const std::size_t count = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  if (width == size && height == size) {
    return {rgba, rgba + 4 * count};
  }
  std::vector<Pixel> linear(count);
  for (std::size_t i = 0; i < 4 * count; ++i) {
    const float value = static_cast<float>(rgba[i]) / 255.0f;
    linear[i / 4][i % 4] = i % 4 == 3 ? value : srgbToLinear(value);
  }
  linear = resampleTransposed(linear, width, height, size);
  linear = resampleTransposed(linear, height, size, size);
  std::vector<std::uint8_t> bytes(4 * linear.size());
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    const float value = linear[i / 4][i % 4];
    bytes[i] = toByte(i % 4 == 3 ? value : linearToSrgb(value));
  }
  return bytes;
}

}  // namespace limber::render
