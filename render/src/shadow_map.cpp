// SPDX-License-Identifier: Zlib
#include "shadow_map.h"

#include <array>
#include <stdexcept>
#include <string>

namespace limber::render {
namespace {

GlTexture makeDepth(const Gl& gl, int size) {
  GLint largest = 0;
  gl.GetIntegerv(GL_MAX_TEXTURE_SIZE, &largest);
  if (size < 1 || size > largest) {
    throw std::runtime_error("a shadow map of " + std::to_string(size) + " texels per side is not possible");
  }
  GLuint name = 0;
  gl.CreateTextures(GL_TEXTURE_2D, 1, &name);
  GlTexture depth(gl, name, 4 * static_cast<std::size_t>(size) * static_cast<std::size_t>(size));
  // Fixed point, because OpenGL then clamps what is compared: beyond the map's far end all is lit.
  gl.TextureStorage2D(name, 1, GL_DEPTH_COMPONENT24, size, size);
  gl.TextureParameteri(name, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  gl.TextureParameteri(name, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  gl.TextureParameteri(name, GL_TEXTURE_COMPARE_MODE, GL_COMPARE_REF_TO_TEXTURE);
  gl.TextureParameteri(name, GL_TEXTURE_COMPARE_FUNC, GL_LEQUAL);
  // What lies beside the map is lit, too.
  const std::array<GLfloat, 4> border{1.0f, 1.0f, 1.0f, 1.0f};
  gl.TextureParameteri(name, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_BORDER);
  gl.TextureParameteri(name, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_BORDER);
  gl.TextureParameterfv(name, GL_TEXTURE_BORDER_COLOR, border.data());
  return depth;
}

}  // namespace

ShadowMap::ShadowMap(const Gl& gl, int size)
    : gl_(gl), size_(size), depth_(makeDepth(gl, size)), framebuffer_(makeFramebuffer(gl)) {
  gl.NamedFramebufferTexture(framebuffer_.name(), GL_DEPTH_ATTACHMENT, depth_.name(), 0);
  gl.NamedFramebufferDrawBuffer(framebuffer_.name(), GL_NONE);
  gl.NamedFramebufferReadBuffer(framebuffer_.name(), GL_NONE);
  if (gl.CheckNamedFramebufferStatus(framebuffer_.name(), GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE) {
    throw std::runtime_error("the driver refused the shadow map");
  }
}

void ShadowMap::begin() const {
  const GLfloat farthest = 1.0f;
  gl_.BindFramebuffer(GL_DRAW_FRAMEBUFFER, framebuffer_.name());
  gl_.Viewport(0, 0, size_, size_);
  gl_.DepthMask(GL_TRUE);
  gl_.ClearNamedFramebufferfv(framebuffer_.name(), GL_DEPTH, 0, &farthest);
}

}  // namespace limber::render
