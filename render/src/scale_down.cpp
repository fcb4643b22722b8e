// SPDX-License-Identifier: Zlib
#include "scale_down.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <stdexcept>

#include "srgb.h"

namespace limber::render {
namespace {

constexpr std::size_t kLinearWhite = 65535;  // Fine enough to tell the darkest two levels of sRGB by 20.

// sRGB to linear light and back, in whole numbers: fast, and the same on every machine.
struct LightTables {
  std::array<std::uint16_t, 256> linear;
  std::array<std::uint8_t, kLinearWhite + 1> srgb;

  LightTables() {
    const auto white = static_cast<float>(kLinearWhite);
    for (std::size_t i = 0; i < linear.size(); ++i) {
      linear[i] =
          static_cast<std::uint16_t>(std::lround(white * srgbToLinear(static_cast<float>(i) / 255.0f)));
    }
    for (std::size_t i = 0; i < srgb.size(); ++i) {
      srgb[i] = static_cast<std::uint8_t>(std::lround(255.0f * linearToSrgb(static_cast<float>(i) / white)));
    }
  }
};

const LightTables& lightTables() {
  static const LightTables tables;
  return tables;
}

void averagePixels(const Image& source, const PixelArea& area, const LightTables& tables, std::uint8_t* out) {
  std::array<std::uint64_t, 3> sum{};
  for (int y = area.y; y < area.y + area.height; ++y) {
    const std::uint8_t* pixel = source.pixel(area.x, y);
    for (int x = 0; x < area.width; ++x, pixel += 4) {
      for (std::size_t c = 0; c < 3; ++c) {
        sum[c] += tables.linear[pixel[c]];
      }
    }
  }
  const auto count = static_cast<std::uint64_t>(area.width) * static_cast<std::uint64_t>(area.height);
  for (std::size_t c = 0; c < 3; ++c) {
    out[c] = tables.srgb[(sum[c] + count / 2) / count];
  }
  out[3] = 255;
}

struct Range {
  int first;
  int count;
};

// Source pixels under pixel i of `count`; at least one.
Range sourceRange(int i, int count, int sourceCount) {
  const int first = static_cast<int>(static_cast<long long>(i) * sourceCount / count);
  const int last = static_cast<int>((static_cast<long long>(i) + 1) * sourceCount / count);
  return {first, std::max(last - first, 1)};
}

}  // namespace

void drawScaled(const Image& source, Image& target, const PixelArea& area) {
  const LightTables& tables = lightTables();
  for (int y = 0; y < area.height; ++y) {
    const Range rows = sourceRange(y, area.height, source.height);
    for (int x = 0; x < area.width; ++x) {
      const Range columns = sourceRange(x, area.width, source.width);
      averagePixels(source, {columns.first, rows.first, columns.count, rows.count}, tables,
                    target.pixel(area.x + x, area.y + y));
    }
  }
}

Image scaledDown(const Image& image, int width) {
  if (image.width < 1 || image.height < 1 || width < 1) {
    throw std::runtime_error("only an image that is not empty can be scaled down, to one pixel at least");
  }
  Image out;
  out.resize(width, std::max(1, width * image.height / image.width));
  drawScaled(image, out, {0, 0, out.width, out.height});
  return out;
}

}  // namespace limber::render
