// SPDX-License-Identifier: Zlib
#pragma once

#include <string_view>
#include <vector>

namespace limber::render {

/// A bar of a letter, from the text's upper left corner. All letters are made of bars of width 1.
struct TextBar {
  float left, top, width, height;
};

/// Digits and capital letters have this height; letters such as g reach 2 below.
constexpr float kTextHeight = 7.0f;

/// Returns the bars of a text of one line. Characters outside ASCII are left blank. The font is that of
/// stb_easy_font.h (Sean Barrett, public domain).
std::vector<TextBar> textBars(std::string_view text);

/// Returns the width of a text without the space after its last letter; 0 if it is empty.
float textWidth(std::string_view text);

}  // namespace limber::render
