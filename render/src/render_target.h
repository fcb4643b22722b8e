// SPDX-License-Identifier: Zlib
#pragma once

#include <cstddef>

#include "limber/render/gl_objects.h"
#include "limber/render/image.h"

namespace limber::render {

/// The picture that is drawn into: sRGB colour and depth, optionally multisampled.
class RenderTarget {
 public:
  /// Throws std::runtime_error if the driver cannot make a target like this.
  RenderTarget(const Gl& gl, int width, int height, int samples);

  int width() const { return width_; }
  int height() const { return height_; }
  std::size_t bytes() const;

  /// Makes it the target of what follows and clears the depth. The colour is left as it is.
  void begin() const;
  /// Averages the samples; call after the last draw.
  void resolve() const;
  /// Copies the resolved picture, waiting for it.
  void read(Image& image) const;
  /// See Renderer::blitTo().
  void blitTo(GLuint framebuffer, int x, int y, int width, int height) const;
  GLuint texture() const { return samples_ > 1 ? resolved_.name() : colour_.name(); }

 private:
  GLuint readable() const { return samples_ > 1 ? readable_.name() : drawn_.name(); }
  GlTexture makeAttachment(GLenum format, int samples, std::size_t bytesPerSample) const;

  const Gl& gl_;
  int width_;
  int height_;
  int samples_;
  GlTexture colour_;
  GlTexture depth_;
  GlTexture resolved_;
  GlFramebuffer drawn_;
  GlFramebuffer readable_;
};

}  // namespace limber::render
