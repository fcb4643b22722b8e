// SPDX-License-Identifier: Zlib
#pragma once

namespace limber::render {

/// A rectangle of an image's pixels; y counts from the top.
struct PixelArea {
  int x = 0;
  int y = 0;
  int width = 0;
  int height = 0;
};

}  // namespace limber::render
