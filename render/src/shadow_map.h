// SPDX-License-Identifier: Zlib
#pragma once

#include <cstddef>

#include "limber/render/gl_objects.h"

namespace limber::render {

/// Depth as seen from the light.
class ShadowMap {
 public:
  /// `size` texels per side.
  ShadowMap(const Gl& gl, int size);

  int size() const { return size_; }
  std::size_t bytes() const { return depth_.bytes(); }
  GLuint texture() const { return depth_.name(); }
  /// Makes it the target of what follows and clears it.
  void begin() const;

 private:
  const Gl& gl_;
  int size_;
  GlTexture depth_;
  GlFramebuffer framebuffer_;
};

}  // namespace limber::render
