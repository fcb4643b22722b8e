// SPDX-License-Identifier: Zlib
#include "limber/render/text.h"

#include <stb_easy_font.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>

namespace limber::render {
namespace {

/// A corner of a bar as stb_easy_font.h writes it: four for each bar, clockwise from the upper left one.
struct Corner {
  float x, y, z;
  std::array<std::uint8_t, 4> colour;
};

/// The font has the characters from blank to tilde; it takes no const.
std::string printable(std::string_view text) {
  std::string line(text);
  std::replace_if(
      line.begin(), line.end(), [](char c) { return c < ' ' || c > '~'; }, ' ');
  return line;
}

}  // namespace

std::vector<TextBar> textBars(std::string_view text) {
  constexpr std::size_t kMaxBars = 16;  // of a letter
  std::string line = printable(text);
  std::vector<Corner> corners(4 * kMaxBars * line.size());
  const int count = stb_easy_font_print(0.0f, 0.0f, line.data(), nullptr, corners.data(),
                                        static_cast<int>(corners.size() * sizeof(Corner)));
  std::vector<TextBar> bars;
  for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
    const Corner &first = corners[4 * i], &opposite = corners[4 * i + 2];
    bars.push_back({first.x, first.y, opposite.x - first.x, opposite.y - first.y});
  }
  return bars;
}

float textWidth(std::string_view text) {
  float width = 0.0f;
  for (const TextBar& bar : textBars(text)) {
    width = std::max(width, bar.left + bar.width);
  }
  return width;
}

}  // namespace limber::render
