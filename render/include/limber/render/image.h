// SPDX-License-Identifier: Zlib
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace limber::render {

/// RGBA, 8 bits each, sRGB, rows from the top down, no padding.
struct Image {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> rgba;  ///< 4 x width x height.

  void resize(int newWidth, int newHeight) {
    width = newWidth;
    height = newHeight;
    rgba.resize(4u * static_cast<std::size_t>(newWidth) * static_cast<std::size_t>(newHeight));
  }
  /// The four bytes of a pixel; x counts from the left, y from the top.
  const std::uint8_t* pixel(int x, int y) const {
    return rgba.data() +
           4u * (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x));
  }
  std::uint8_t* pixel(int x, int y) {
    return const_cast<std::uint8_t*>(static_cast<const Image*>(this)->pixel(x, y));
  }
};

/// Returns an opaque image, scaled down to `width` pixels (at least 1) with the same aspect ratio. Each pixel
/// is the mean of the source pixels that it covers, in linear light. Throws std::runtime_error if the image
/// is empty.
Image scaledDown(const Image& image, int width);

/// Returns pictures side by side in rows of `columns` (at least 1). Each is scaled down to a width of
/// `tileWidth` pixels. There is a thin gap between them, and the last row may be shorter. All have the aspect
/// ratio of the first image. Throws std::runtime_error if there is no image or one is empty.
Image contactSheet(const std::vector<Image>& images, int columns, int tileWidth = 320);

}  // namespace limber::render
