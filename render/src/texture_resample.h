// SPDX-License-Identifier: Zlib
#pragma once

#include <cstdint>
#include <vector>

namespace limber::render {

/// An sRGB RGBA picture, `width` x `height`, filtered in linear light to a square of `size`. Edges
/// wrap around, as the texture will when it repeats. A picture of that size already is only copied.
std::vector<std::uint8_t> resampleToSquare(int width, int height, const std::uint8_t* rgba, int size);

}  // namespace limber::render
