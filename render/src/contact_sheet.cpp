// SPDX-License-Identifier: Zlib
#include <algorithm>
#include <cstddef>
#include <stdexcept>
#include <string>

#include "limber/render/image.h"
#include "scale_down.h"

namespace limber::render {
namespace {

constexpr int kGap = 4;
constexpr std::uint8_t kGapGrey = 255;

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
  for (int i = 0; i < count; ++i) {
    const int x = (i % usedColumns) * (tileWidth + kGap);
    const int y = (i / usedColumns) * (tileHeight + kGap);
    drawScaled(images[static_cast<std::size_t>(i)], sheet, {x, y, tileWidth, tileHeight});
  }
  return sheet;
}

}  // namespace limber::render
