// SPDX-License-Identifier: Zlib
#include "pixels.h"

#include "limber/render/image.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <string>

namespace limber::render {
namespace {

constexpr std::size_t kLinearWhite = 65535;  // Fine enough: the two darkest levels of sRGB differ by 20.

// Conversion of sRGB to linear light and back in integers: fast, and equal on every machine.
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

// Returns the source pixels that pixel i of `count` covers; at least one.
Range sourceRange(int i, int count, int sourceCount) {
  const int first = static_cast<int>(static_cast<long long>(i) * sourceCount / count);
  const int last = static_cast<int>((static_cast<long long>(i) + 1) * sourceCount / count);
  return {first, std::max(last - first, 1)};
}

/// Fills an area of `target` with the whole `source`, opaque. Each pixel is the mean of the source pixels
/// that it covers, in linear light, or the nearest one if it covers none.
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

constexpr int kGap = 4;
constexpr std::uint8_t kGapGrey = 255;

}  // namespace

Image scaledDown(const Image& image, int width) {
  if (image.width < 1 || image.height < 1 || width < 1) {
    throw std::runtime_error("only an image that is not empty can be scaled down, to one pixel at least");
  }
  Image out;
  out.resize(width, std::max(1, width * image.height / image.width));
  drawScaled(image, out, {0, 0, out.width, out.height});
  return out;
}

Image contactSheet(const std::vector<Image>& images, int columns, int tileWidth) {
  if (images.empty() || columns < 1 || tileWidth < 1) {
    throw std::runtime_error("a contact sheet needs at least one image, column and pixel");
  }
  for (std::size_t i = 0; i < images.size(); ++i) {
    if (images[i].width < 1 || images[i].height < 1) {
      throw std::runtime_error("image " + std::to_string(i) + " of the contact sheet is empty");
    }
  }
  const int tileHeight = std::max(1, tileWidth * images[0].height / images[0].width);
  const int count = static_cast<int>(images.size());
  const int usedColumns = std::min(columns, count);
  const int rows = (count + usedColumns - 1) / usedColumns;
  Image sheet;
  sheet.resize(usedColumns * (tileWidth + kGap) - kGap, rows * (tileHeight + kGap) - kGap);
  std::fill(sheet.rgba.begin(), sheet.rgba.end(), kGapGrey);
  for (int i = 0; i < count; ++i) {
    const int x = (i % usedColumns) * (tileWidth + kGap);
    const int y = (i / usedColumns) * (tileHeight + kGap);
    drawScaled(images[static_cast<std::size_t>(i)], sheet, {x, y, tileWidth, tileHeight});
  }
  return sheet;
}

namespace {

using Pixel = std::array<float, 4>;

struct Tap {
  std::size_t source = 0;
  float weight = 0.0f;
};

std::size_t wrap(int i, int count) { return static_cast<std::size_t>(((i % count) + count) % count); }

// A tent filter. Its radius is one texel of the coarser picture, so it is bilinear when it enlarges.
std::vector<Tap> tapsFor(int target, int targetCount, int sourceCount) {
  const float scale = static_cast<float>(sourceCount) / static_cast<float>(targetCount);
  const float radius = std::max(scale, 1.0f);
  const float centre = (static_cast<float>(target) + 0.5f) * scale - 0.5f;
  std::vector<Tap> taps;
  float sum = 0.0f;
  for (int i = static_cast<int>(std::ceil(centre - radius)); static_cast<float>(i) <= centre + radius; ++i) {
    const float weight = 1.0f - std::abs(static_cast<float>(i) - centre) / radius;
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

// Resamples rows to `newWidth` and transposes the picture. Two calls resample both directions.
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
