// SPDX-License-Identifier: Zlib
#pragma once

#include <array>
#include <cstddef>
#include <memory>

#include "limber/render/gl_functions.h"

namespace limber::render {

/// The state of a context that the renderer changes or that could change its pictures.
struct GlState {
  static constexpr std::size_t kCaps = 26;
  static constexpr std::size_t kValues = 33;
  static constexpr std::size_t kStorageBindings = 7;  ///< The highest StorageBinding plus one.
  static constexpr std::size_t kTextureUnits = 4;

  struct BufferRange {
    GLint buffer = 0;
    GLint64 start = 0, size = 0;
  };
  struct TextureUnit {
    GLint flat = 0, array = 0, sampler = 0;
  };

  std::array<GLboolean, kCaps> caps{};
  std::array<GLint, kValues> values{};
  std::array<GLint, 2> polygonMode{};
  bool feedbackPaused = false;  ///< By readState().

  // Of viewport 0 and draw buffer 0: the renderer uses no others.
  GLboolean blend = GL_FALSE, scissor = GL_FALSE;
  std::array<GLint, 4> colourMask{};
  std::array<GLfloat, 4> viewport{};
  std::array<GLfloat, 2> depthRange{};

  BufferRange uniforms;
  std::array<BufferRange, kStorageBindings> storage{};
  std::array<TextureUnit, kTextureUnits> textures{};
};

/// Pauses active transform feedback, under which programs cannot be changed.
GlState readState(const Gl& gl);
/// Resumes what readState() has paused.
void writeState(const Gl& gl, const GlState& state);

/// Sets the state that the renderer's passes rely on.
void setRendererState(const Gl& gl);

inline void setCap(const Gl& gl, GLenum cap, bool on) { on ? gl.Enable(cap) : gl.Disable(cap); }

/// In a shared context: sets the renderer's state in the constructor, restores the caller's in the
/// destructor.
class GlStateGuard {
 public:
  GlStateGuard(const Gl& gl, bool shared);
  ~GlStateGuard();
  GlStateGuard(const GlStateGuard&) = delete;
  GlStateGuard& operator=(const GlStateGuard&) = delete;

 private:
  const Gl& gl_;
  std::unique_ptr<GlState> callerState_;  // Null if the context is not shared.
};

}  // namespace limber::render
