// SPDX-License-Identifier: Zlib
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <stdexcept>
#include <string>

#include "limber/render/image.h"
#include "srgb.h"

namespace limber::render {
namespace {

constexpr int kGap = 4;
constexpr std::uint8_t kGapGrey = 255;

using LinearTable = std::array<float, 256>;

LinearTable makeLinearTable() {
  LinearTable table{};
  for (std::size_t i = 0; i < table.size(); ++i) {
    table[i] = srgbToLinear(static_cast<float>(i) / 255.0f);
  }
  return table;
}

struct Box {
  int x0, y0, x1, y1;
};

// The mean of the pixels of a box, taken in linear light.
void averageBox(const Image& source, const Box& box, const LinearTable& linear, std::uint8_t* out) {
  std::array<float, 3> sum{};
  for (int y = box.y0; y < box.y1; ++y) {
    for (int x = box.x0; x < box.x1; ++x) {
      for (std::size_t c = 0; c < 3; ++c) {
        sum[c] += linear[source.pixel(x, y)[c]];
      }
    }
  }
  const auto count = static_cast<float>((box.x1 - box.x0) * (box.y1 - box.y0));
  for (std::size_t c = 0; c < 3; ++c) {
    out[c] = static_cast<std::uint8_t>(std::lround(255.0f * linearToSrgb(sum[c] / count)));
  }
  out[3] = 255;
}

// Source pixels under pixel i of `count`; at least one.
std::array<int, 2> sourceRange(int i, int count, int sourceCount) {
  const int first = static_cast<int>(static_cast<long long>(i) * sourceCount / count);
  const int last = static_cast<int>((static_cast<long long>(i) + 1) * sourceCount / count);
  return {first, std::max(last, first + 1)};
}

void drawTile(const Image& source, Image& sheet, const Box& tile, const LinearTable& linear) {
  for (int y = tile.y0; y < tile.y1; ++y) {
    const auto rows = sourceRange(y - tile.y0, tile.y1 - tile.y0, source.height);
    for (int x = tile.x0; x < tile.x1; ++x) {
      const auto columns = sourceRange(x - tile.x0, tile.x1 - tile.x0, source.width);
      averageBox(source, {columns[0], rows[0], columns[1], rows[1]}, linear, sheet.pixel(x, y));
    }
  }
}

}  // namespace

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
  const LinearTable linear = makeLinearTable();
  for (int i = 0; i < count; ++i) {
    const int x = (i % usedColumns) * (tileWidth + kGap);
    const int y = (i / usedColumns) * (tileHeight + kGap);
    drawTile(images[static_cast<std::size_t>(i)], sheet, {x, y, x + tileWidth, y + tileHeight}, linear);
  }
  return sheet;
}

}  // namespace limber::render
