// SPDX-License-Identifier: Zlib
#include "render_target.h"

#include <stdexcept>
#include <string>

namespace limber::render {
namespace {

constexpr GLenum kColourFormat = GL_SRGB8_ALPHA8;
constexpr GLenum kDepthFormat = GL_DEPTH_COMPONENT32F;

void requireSize(const Gl& gl, int width, int height, int samples) {
  GLint largest = 0;
  GLint mostSamples = 0;
  gl.GetIntegerv(GL_MAX_TEXTURE_SIZE, &largest);
  gl.GetIntegerv(GL_MAX_SAMPLES, &mostSamples);
  if (width < 1 || height < 1 || width > largest || height > largest) {
    throw std::runtime_error("a picture of " + std::to_string(width) + " x " + std::to_string(height) +
                             " pixels is not possible; each side must be 1 to " + std::to_string(largest));
  }
  if (samples < 1 || samples > mostSamples) {
    throw std::runtime_error(std::to_string(samples) +
                             " samples per pixel are not possible; this driver has 1 to " +
                             std::to_string(mostSamples));
  }
}

void requireComplete(const Gl& gl, const GlFramebuffer& framebuffer) {
  const GLenum status = gl.CheckNamedFramebufferStatus(framebuffer.name(), GL_FRAMEBUFFER);
  if (status != GL_FRAMEBUFFER_COMPLETE) {
    throw std::runtime_error("the driver refused the render target (framebuffer status " +
                             std::to_string(status) + ")");
  }
}

}  // namespace

RenderTarget::RenderTarget(const Gl& gl, int width, int height, int samples)
    : gl_(gl), width_(width), height_(height), samples_(samples) {
  requireSize(gl, width, height, samples);
  colour_ = makeAttachment(kColourFormat, samples, 4);
  depth_ = makeAttachment(kDepthFormat, samples, 4);
  drawn_ = makeFramebuffer(gl);
  gl.NamedFramebufferTexture(drawn_.name(), GL_COLOR_ATTACHMENT0, colour_.name(), 0);
  gl.NamedFramebufferTexture(drawn_.name(), GL_DEPTH_ATTACHMENT, depth_.name(), 0);
  requireComplete(gl, drawn_);
  if (samples > 1) {
    resolved_ = makeAttachment(kColourFormat, 1, 4);
    readable_ = makeFramebuffer(gl);
    gl.NamedFramebufferTexture(readable_.name(), GL_COLOR_ATTACHMENT0, resolved_.name(), 0);
    requireComplete(gl, readable_);
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

void RenderTarget::begin() const {
  const GLfloat farthest = 1.0f;
  gl_.BindFramebuffer(GL_DRAW_FRAMEBUFFER, drawn_.name());
  gl_.Viewport(0, 0, width_, height_);
  gl_.DepthMask(GL_TRUE);
  gl_.ClearNamedFramebufferfv(drawn_.name(), GL_DEPTH, 0, &farthest);
}

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
  // Bytes are copied as they are: the colours are encoded already, whatever the other calls its format.
  gl_.Disable(GL_FRAMEBUFFER_SRGB);
  const bool sameSize = width == width_ && height == height_;
  gl_.BlitNamedFramebuffer(readable(), framebuffer, 0, 0, width_, height_, x, y + height, x + width, y,
                           GL_COLOR_BUFFER_BIT, sameSize ? GL_NEAREST : GL_LINEAR);
  gl_.Enable(GL_FRAMEBUFFER_SRGB);
}

}  // namespace limber::render
