// SPDX-License-Identifier: Zlib
#include "gpu_textures.h"

#include "pixels.h"

#include <algorithm>
#include <array>
#include <stdexcept>
#include <string>

namespace limber::render {
namespace {

constexpr GLenum kColourFormat = GL_SRGB8_ALPHA8;
constexpr GLenum kDepthFormat = GL_DEPTH_COMPONENT32F;

void requireSize(const Gl& gl, int width, int height, int samples) {
  GLint maxSize = 0;
  GLint maxSamples = 0;
  gl.GetIntegerv(GL_MAX_TEXTURE_SIZE, &maxSize);
  gl.GetIntegerv(GL_MAX_SAMPLES, &maxSamples);
  if (width < 1 || height < 1 || width > maxSize || height > maxSize) {
    throw std::runtime_error("a picture of " + std::to_string(width) + " x " + std::to_string(height) +
                             " pixels is not possible; each side must be 1 to " + std::to_string(maxSize));
  }
  if (samples < 1 || samples > maxSamples) {
    throw std::runtime_error(std::to_string(samples) +
                             " samples per pixel are not possible; this driver has 1 to " +
                             std::to_string(maxSamples));
  }
}

void requireComplete(const Gl& gl, const GlFramebuffer& framebuffer) {
  const GLenum status = gl.CheckNamedFramebufferStatus(framebuffer.name(), GL_FRAMEBUFFER);
  if (status != GL_FRAMEBUFFER_COMPLETE) {
    throw std::runtime_error("the driver refused the render target (framebuffer status " +
                             std::to_string(status) + ")");
  }
}

GlFramebuffer targetOf(const Gl& gl, GLenum attachment, const GlTexture& texture) {
  GlFramebuffer target = makeFramebuffer(gl);
  gl.NamedFramebufferTexture(target.name(), attachment, texture.name(), 0);
  if (attachment == GL_DEPTH_ATTACHMENT) {
    gl.NamedFramebufferDrawBuffer(target.name(), GL_NONE);
    gl.NamedFramebufferReadBuffer(target.name(), GL_NONE);
  }
  requireComplete(gl, target);
  return target;
}

// Binds the target of the next draws and clears its depth.
void beginDepthOf(const Gl& gl, const GlFramebuffer& target, int width, int height) {
  const GLfloat farthest = 1.0f;
  gl.BindFramebuffer(GL_DRAW_FRAMEBUFFER, target.name());
  gl.ViewportIndexedf(0, 0.0f, 0.0f, static_cast<GLfloat>(width), static_cast<GLfloat>(height));
  gl.DepthMask(GL_TRUE);
  gl.ClearNamedFramebufferfv(target.name(), GL_DEPTH, 0, &farthest);
}

}  // namespace

RenderTarget::RenderTarget(const Gl& gl, int width, int height, int samples)
    : gl_(gl), width_(width), height_(height), samples_(samples) {
  requireSize(gl, width, height, samples);
  colour_ = makeAttachment(kColourFormat, samples, 4);
  depth_ = makeAttachment(kDepthFormat, samples, 4);
  drawn_ = targetOf(gl, GL_COLOR_ATTACHMENT0, colour_);
  gl.NamedFramebufferTexture(drawn_.name(), GL_DEPTH_ATTACHMENT, depth_.name(), 0);
  requireComplete(gl, drawn_);
  if (samples > 1) {
    resolved_ = makeAttachment(kColourFormat, 1, 4);
    readable_ = targetOf(gl, GL_COLOR_ATTACHMENT0, resolved_);
  }
}

GlTexture RenderTarget::makeAttachment(GLenum format, int samples, std::size_t bytesPerSample) const {
  const std::size_t bytes = bytesPerSample * static_cast<std::size_t>(samples) *
                            static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_);
  GLuint name = 0;
  gl_.CreateTextures(samples > 1 ? GL_TEXTURE_2D_MULTISAMPLE : GL_TEXTURE_2D, 1, &name);
  GlTexture texture(gl_, name, bytes);
  if (samples > 1) {
    gl_.TextureStorage2DMultisample(name, samples, format, width_, height_, GL_TRUE);
  } else {
    gl_.TextureStorage2D(name, 1, format, width_, height_);
  }
  return texture;
}

std::size_t RenderTarget::bytes() const { return colour_.bytes() + depth_.bytes() + resolved_.bytes(); }

void RenderTarget::begin() const { beginDepthOf(gl_, drawn_, width_, height_); }

void RenderTarget::resolve() const {
  if (samples_ > 1) {
    gl_.BlitNamedFramebuffer(drawn_.name(), readable_.name(), 0, 0, width_, height_, 0, 0, width_, height_,
                             GL_COLOR_BUFFER_BIT, GL_NEAREST);
  }
}

void RenderTarget::read(Image& image) const {
  image.resize(width_, height_);
  gl_.BindFramebuffer(GL_READ_FRAMEBUFFER, readable());
  gl_.PixelStorei(GL_PACK_ALIGNMENT, 1);
  gl_.ReadPixels(0, 0, width_, height_, GL_RGBA, GL_UNSIGNED_BYTE, image.rgba.data());
}

void RenderTarget::blitTo(GLuint framebuffer, int x, int y, int width, int height) const {
  if (framebuffer != 0 && gl_.IsFramebuffer(framebuffer) == GL_FALSE) {
    throw std::runtime_error("blitTo: there is no framebuffer " + std::to_string(framebuffer));
  }
  if (gl_.CheckNamedFramebufferStatus(framebuffer, GL_DRAW_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE) {
    throw std::runtime_error("blitTo: framebuffer " + std::to_string(framebuffer) + " is not complete");
  }
  // Copy the bytes unchanged: the colours are already encoded, whatever the format of the target is.
  gl_.Disable(GL_FRAMEBUFFER_SRGB);
  takeGlErrors(gl_);
  const bool sameSize = width == width_ && height == height_;
  gl_.BlitNamedFramebuffer(readable(), framebuffer, 0, 0, width_, height_, x, y + height, x + width, y,
                           GL_COLOR_BUFFER_BIT, sameSize ? GL_NEAREST : GL_LINEAR);
  gl_.Enable(GL_FRAMEBUFFER_SRGB);
  // such as for a framebuffer with samples and another size
  checkGlErrors(gl_, "blitTo");
}

namespace {

GlTexture makePlane(const Gl& gl, GLenum format, int width, int height, std::size_t bytesPerPixel,
                    GLint filter = GL_NEAREST) {
  GLuint name = 0;
  gl.CreateTextures(GL_TEXTURE_2D, 1, &name);
  GlTexture plane(gl, name,
                  bytesPerPixel * static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  gl.TextureStorage2D(name, 1, format, width, height);
  gl.TextureParameteri(name, GL_TEXTURE_MIN_FILTER, filter);
  gl.TextureParameteri(name, GL_TEXTURE_MAG_FILTER, filter);
  return plane;
}

GlTexture makeDepth(const Gl& gl, int size, bool comparing) {
  // Fixed point, because OpenGL then clamps the compared depth: everything beyond the far end is lit.
  GlTexture depth = makePlane(gl, GL_DEPTH_COMPONENT24, size, size, 4, comparing ? GL_LINEAR : GL_NEAREST);
  const GLuint name = depth.name();
  gl.TextureParameteri(name, GL_TEXTURE_COMPARE_MODE, comparing ? GL_COMPARE_REF_TO_TEXTURE : GL_NONE);
  gl.TextureParameteri(name, GL_TEXTURE_COMPARE_FUNC, GL_LEQUAL);
  // Everything beside the map is lit, too.
  const std::array<GLfloat, 4> border{1.0f, 1.0f, 1.0f, 1.0f};
  gl.TextureParameteri(name, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_BORDER);
  gl.TextureParameteri(name, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_BORDER);
  gl.TextureParameterfv(name, GL_TEXTURE_BORDER_COLOR, border.data());
  return depth;
}

}  // namespace

ShadowMap::ShadowMap(const Gl& gl, int size, bool comparing)
    : gl_(gl),
      size_(size),
      depth_(makeDepth(gl, size, comparing)),
      framebuffer_(targetOf(gl, GL_DEPTH_ATTACHMENT, depth_)) {}

void ShadowMap::begin() const { beginDepthOf(gl_, framebuffer_, size_, size_); }

OpennessMap::OpennessMap(const Gl& gl, int width, int height)
    : gl_(gl),
      width_(width),
      height_(height),
      depth_(makePlane(gl, kDepthFormat, width, height, 4)),
      raw_(makePlane(gl, GL_R8, width, height, 1)),
      smooth_(makePlane(gl, GL_R8, width, height, 1)),
      depthTarget_(targetOf(gl, GL_DEPTH_ATTACHMENT, depth_)),
      rawTarget_(targetOf(gl, GL_COLOR_ATTACHMENT0, raw_)),
      smoothTarget_(targetOf(gl, GL_COLOR_ATTACHMENT0, smooth_)) {}

void OpennessMap::beginDepth() const { beginDepthOf(gl_, depthTarget_, width_, height_); }

void OpennessMap::beginRaw() const {
  gl_.BindFramebuffer(GL_DRAW_FRAMEBUFFER, rawTarget_.name());
  gl_.BindTextureUnit(2, depth_.name());
}

void OpennessMap::beginSmooth() const {
  gl_.BindFramebuffer(GL_DRAW_FRAMEBUFFER, smoothTarget_.name());
  gl_.BindTextureUnit(3, raw_.name());
}

namespace {

GLsizei levelsFor(int size) {
  GLsizei levels = 1;
  while ((size >> levels) > 0) {
    ++levels;
  }
  return levels;
}

}  // namespace

TextureArray::TextureArray(const Gl& gl, int size)
    : gl_(gl), size_(size), levels_(levelsFor(size)), texture_(make(1)) {}

GlTexture TextureArray::make(std::uint32_t layers) const {
  std::size_t bytes = 0;
  for (GLsizei level = 0; level < levels_; ++level) {
    const auto side = static_cast<std::size_t>(size_ >> level);
    bytes += 4 * side * side * layers;
  }
  GLuint name = 0;
  gl_.CreateTextures(GL_TEXTURE_2D_ARRAY, 1, &name);
  GlTexture texture(gl_, name, bytes);
  takeGlErrors(gl_);
  gl_.TextureStorage3D(name, levels_, GL_SRGB8_ALPHA8, size_, size_, static_cast<GLsizei>(layers));
  if (!takeGlErrors(gl_).empty()) {
    throw std::runtime_error("the driver refused " + std::to_string(layers) + " textures of " +
                             std::to_string(size_) + " x " + std::to_string(size_) + " pixels");
  }
  gl_.TextureParameteri(name, GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_LINEAR);
  gl_.TextureParameteri(name, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  gl_.TextureParameteri(name, GL_TEXTURE_WRAP_S, GL_REPEAT);
  gl_.TextureParameteri(name, GL_TEXTURE_WRAP_T, GL_REPEAT);
  return texture;
}

void TextureArray::grow() {
  GLint limit = 0;
  gl_.GetIntegerv(GL_MAX_ARRAY_TEXTURE_LAYERS, &limit);
  if (capacity_ >= static_cast<std::uint32_t>(limit)) {
    throw std::runtime_error("this driver holds no more than " + std::to_string(limit) + " textures");
  }
  const std::uint32_t capacity = std::min(2 * capacity_, static_cast<std::uint32_t>(limit));
  GlTexture larger = make(capacity);
  for (GLint level = 0; level < levels_; ++level) {
    const GLsizei side = size_ >> level;
    gl_.CopyImageSubData(texture_.name(), GL_TEXTURE_2D_ARRAY, level, 0, 0, 0, larger.name(),
                         GL_TEXTURE_2D_ARRAY, level, 0, 0, 0, side, side, static_cast<GLsizei>(count_));
  }
  texture_ = std::move(larger);
  capacity_ = capacity;
}

std::uint32_t TextureArray::add(int width, int height, const std::uint8_t* rgba) {
  if (width < 1 || height < 1) {
    throw std::runtime_error("a texture needs at least one pixel, not " + std::to_string(width) + " x " +
                             std::to_string(height));
  }
  if (rgba == nullptr) {
    throw std::runtime_error("addTexture: rgba is null");
  }
  if (count_ == capacity_) {
    grow();
  }
  const std::vector<std::uint8_t> square = resampleToSquare(width, height, rgba, size_);
  gl_.TextureSubImage3D(texture_.name(), 0, 0, 0, static_cast<GLint>(count_), size_, size_, 1, GL_RGBA,
                        GL_UNSIGNED_BYTE, square.data());
  gl_.GenerateTextureMipmap(texture_.name());
  return count_++;
}

}  // namespace limber::render
