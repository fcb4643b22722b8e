// SPDX-License-Identifier: Zlib
#pragma once

#include <cstddef>
#include <cstdint>

#include "limber/render/gl_objects.h"

namespace limber::render {

/// All textures as layers of one array, so that instances of one draw call may differ in theirs.
class TextureArray {
 public:
  /// `size` texels per side of every layer.
  TextureArray(const Gl& gl, int size);

  /// Returns the layer. Throws std::runtime_error for an empty picture or if there is no room.
  std::uint32_t add(int width, int height, const std::uint8_t* rgba);
  std::uint32_t count() const { return count_; }
  std::size_t bytes() const { return texture_.bytes(); }
  GLuint name() const { return texture_.name(); }

 private:
  GlTexture make(std::uint32_t layers) const;
  void grow();

  const Gl& gl_;
  int size_;
  GLsizei levels_;
  std::uint32_t capacity_ = 1;
  std::uint32_t count_ = 0;
  GlTexture texture_;
};

}  // namespace limber::render
