// SPDX-License-Identifier: Zlib
#pragma once

#include <string_view>

#include "limber/render/overlay.h"

namespace limber::render {

/// Pixels that a text takes from left to right.
float textWidth(std::string_view text, float height);

/// Appends the strokes of a text, in pixels from the picture's upper left corner; `x` and `y` are the text's
/// own, `height` that of a digit.
void addText(Overlay& strokes, std::string_view text, float x, float y, float height, Vec3 colour,
             float width);

}  // namespace limber::render
