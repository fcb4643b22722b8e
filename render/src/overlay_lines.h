// SPDX-License-Identifier: Zlib
#pragma once

#include "limber/render/gl_objects.h"
#include "limber/render/legend.h"
#include "limber/render/overlay.h"

#include <array>
#include <cstddef>
#include <string_view>
#include <vector>

namespace limber::render {

/// The overlay of a frame on the GPU.
class OverlayLines {
 public:
  explicit OverlayLines(const Gl& gl) : gl_(gl) {}

  void upload(const Overlay& overlay);
  GLuint buffer() const { return buffer_.name(); }
  GLsizei count() const { return count_; }
  std::size_t bytes() const { return buffer_.bytes(); }

 private:
  /// The format that overlay.vert reads.
  using Packed = std::array<float, 8>;

  const Gl& gl_;
  GlBuffer buffer_;
  std::vector<Packed> staging_;
  GLsizei count_ = 0;
};

/// Appends the bars of a text as lines, in pixels from the picture's upper left corner. `x` and `y` are the
/// text's upper left corner, `height` is that of a digit. Bars are wider by `rim` on all sides.
void addText(Overlay& strokes, std::string_view text, float x, float y, float height, Vec3 colour, float rim);

/// Pixels from the upper left corner of the picture.
struct BarRectangle {
  float left, top, width, height;
};

/// Returns the bar of legend number `row`, counted from the bottom.
BarRectangle barRectangle(std::size_t row, int pictureWidth, int pictureHeight);

/// Appends the strokes of the legend's numbers: dark on a light rim, readable on any background.
void addNumbers(Overlay& strokes, const Legend& legend, const BarRectangle& bar);

}  // namespace limber::render
