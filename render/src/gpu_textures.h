// SPDX-License-Identifier: Zlib
#pragma once

#include "limber/render/gl_objects.h"
#include "limber/render/image.h"

#include <cstddef>
#include <cstdint>

namespace limber::render {

/// The picture that the renderer draws: sRGB colour and depth, optionally multisampled.
class RenderTarget {
 public:
  /// Throws std::runtime_error if the driver does not support this target.
  RenderTarget(const Gl& gl, int width, int height, int samples);

  int width() const { return width_; }
  int height() const { return height_; }
  std::size_t bytes() const;

  /// Binds it as the target of the next draws and clears the depth, not the colour.
  void begin() const;
  /// Averages the samples; call it after the last draw.
  void resolve() const;
  /// Waits for the resolved picture and copies it.
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

/// Depth as seen from the light.
class ShadowMap {
 public:
  /// `size` texels per side. `comparing`: look-ups compare and filter, else they return depths.
  ShadowMap(const Gl& gl, int size, bool comparing = true);

  int size() const { return size_; }
  std::size_t bytes() const { return depth_.bytes(); }
  GLuint texture() const { return depth_.name(); }
  /// Binds it as the target of the next draws and clears it.
  void begin() const;

 private:
  const Gl& gl_;
  int size_;
  GlTexture depth_;
  GlFramebuffer framebuffer_;
};

/// How open to its surroundings each pixel of a picture is, and the depths from which that is computed.
class OpennessMap {
 public:
  OpennessMap(const Gl& gl, int width, int height);

  std::size_t bytes() const { return depth_.bytes() + raw_.bytes() + smooth_.bytes(); }
  /// These three bind the targets of the steps, each with the textures of the steps before.
  void beginDepth() const;
  void beginRaw() const;
  void beginSmooth() const;
  GLuint texture() const { return smooth_.name(); }

 private:
  const Gl& gl_;
  int width_, height_;
  GlTexture depth_, raw_, smooth_;
  GlFramebuffer depthTarget_, rawTarget_, smoothTarget_;
};

/// All textures, as layers of one array, so that instances of one draw call can have different textures.
class TextureArray {
 public:
  /// `size` texels per side of every layer.
  TextureArray(const Gl& gl, int size);

  /// Adds a texture and returns its layer. Throws std::runtime_error if it is empty or there are too many.
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
