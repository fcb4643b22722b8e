// SPDX-License-Identifier: Zlib
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "limber/render/gl_objects.h"
#include "limber/render/overlay.h"

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
  /// As overlay.vert reads it.
  using Packed = std::array<float, 8>;

  const Gl& gl_;
  GlBuffer buffer_;
  std::vector<Packed> staging_;
  GLsizei count_ = 0;
};

}  // namespace limber::render
