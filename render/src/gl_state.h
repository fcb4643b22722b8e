// SPDX-License-Identifier: Zlib
#pragma once

#include <array>
#include <cstddef>
#include <memory>

#include "limber/render/gl_functions.h"

namespace limber::render {

/// Everything in a context's state that the renderer changes or that would change its pictures.
struct GlState {
  static constexpr std::size_t kCaps = 15;
  static constexpr std::size_t kValues = 28;
  static constexpr std::size_t kStorageBindings = 7;  ///< One more than the highest of StorageBinding.
  static constexpr std::size_t kTextureUnits = 2;

  struct BufferRange {
    GLint buffer = 0;
    GLint64 start = 0, size = 0;
  };
  struct TextureUnit {
    GLint flat = 0, array = 0, sampler = 0;
  };

  std::array<GLboolean, kCaps> caps{};
  std::array<GLint, kValues> values{};
  std::array<GLint, 4> viewport{}, colourMask{};
  std::array<GLint, 2> polygonMode{};
  std::array<GLfloat, 2> depthRange{};
  BufferRange uniforms;
  std::array<BufferRange, kStorageBindings> storage{};
  std::array<TextureUnit, kTextureUnits> textures{};
};

GlState readState(const Gl& gl);
void writeState(const Gl& gl, const GlState& state);

/// What the renderer's passes take for granted.
void setRendererState(const Gl& gl);

/// In a context that is shared with others: the renderer's state while it lives, then theirs again.
class GlStateGuard {
 public:
  GlStateGuard(const Gl& gl, bool shared);
  ~GlStateGuard();
  GlStateGuard(const GlStateGuard&) = delete;
  GlStateGuard& operator=(const GlStateGuard&) = delete;

 private:
  const Gl& gl_;
  std::unique_ptr<GlState> theirs_;  // Null if the context is the renderer's own.
};

}  // namespace limber::render
