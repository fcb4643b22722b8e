// SPDX-License-Identifier: Zlib
#include "stroke_text.h"

#include <array>
#include <cstddef>

namespace limber::render {
namespace {

// A glyph is a list of strokes; each is a run of points "xy" on a grid 4 wide and 6 high with y down.
struct Glyph {
  char character;
  std::string_view strokes;
};

constexpr std::array<Glyph, 18> kGlyphs{{{'0', "10 30 41 45 36 16 05 01 10"},
                                         {'1', "11 20 26;16 36"},
                                         {'2', "01 10 30 41 42 06 46"},
                                         {'3', "01 10 30 41 42 33 13;33 44 45 36 16 05"},
                                         {'4', "36 30 04 44"},
                                         {'5', "40 00 03 33 44 45 36 06"},
                                         {'6', "40 20 02 05 16 36 45 44 33 03"},
                                         {'7', "00 40 16"},
                                         {'8', "10 30 41 42 33 13 02 01 10;13 04 05 16 36 45 44 33"},
                                         {'9', "06 26 44 41 30 10 01 02 13 43"},
                                         {'-', "13 43"},
                                         {'+', "13 43;21 25"},
                                         {'.', "16 25"},
                                         {'%', "06 40;00 10 11 01 00;35 45 46 36 35"},
                                         {'/', "06 40"},
                                         {'m', "06 02;03 12 23 26;23 32 43 46"},
                                         {'s', "42 12 03 14 34 45 36 06"},
                                         {' ', ""}}};

constexpr float kHeight = 6.0f;   // of the grid
constexpr float kAdvance = 6.0f;  // from one character to the next

std::string_view strokesOf(char character) {
  for (const Glyph& glyph : kGlyphs) {
    if (glyph.character == character) {
      return glyph.strokes;
    }
  }
  return {};
}

}  // namespace

float textWidth(std::string_view text, float height) {
  return text.empty() ? 0.0f : (static_cast<float>(text.size()) * kAdvance - 2.0f) * height / kHeight;
}

void addText(Overlay& strokes, std::string_view text, float x, float y, float height, Vec3 colour,
             float width) {
  const float unit = height / kHeight;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const std::string_view points = strokesOf(text[i]);
    const auto at = [&](std::size_t p) {
      return Vec3{x + unit * (kAdvance * static_cast<float>(i) + static_cast<float>(points[p] - '0')),
                  y + unit * static_cast<float>(points[p + 1] - '0'), 0.0f};
    };
    for (std::size_t p = 0; p + 4 < points.size(); p += 3) {
      if (points[p + 2] == ' ') {
        strokes.push_back({at(p), at(p + 3), colour, width});
      }
    }
  }
}

}  // namespace limber::render
