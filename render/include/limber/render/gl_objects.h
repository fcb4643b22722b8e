// SPDX-License-Identifier: Zlib
#pragma once

#include "limber/render/gl_functions.h"

#include <cstddef>
#include <utility>

namespace limber::render {

/// Owns one OpenGL object; move-only. `bytes` is the size of its storage, for the memory report. Destroy it
/// while its context is current.
template <PFNGLDELETEBUFFERSPROC Gl::*Delete>
class GlObject {
 public:
  GlObject() = default;
  GlObject(const Gl& gl, GLuint name, std::size_t bytes = 0) : gl_(&gl), name_(name), bytes_(bytes) {}
  ~GlObject() { reset(); }
  GlObject(GlObject&& other) noexcept { swap(other); }
  GlObject& operator=(GlObject&& other) noexcept {
    GlObject taken(std::move(other));
    swap(taken);
    return *this;
  }
  GlObject(const GlObject&) = delete;
  GlObject& operator=(const GlObject&) = delete;

  GLuint name() const { return name_; }
  std::size_t bytes() const { return bytes_; }
  explicit operator bool() const { return name_ != 0; }

 private:
  void swap(GlObject& other) noexcept {
    std::swap(gl_, other.gl_);
    std::swap(name_, other.name_);
    std::swap(bytes_, other.bytes_);
  }
  void reset() noexcept {
    if (name_ != 0) {
      (gl_->*Delete)(1, &name_);
    }
    name_ = 0;
  }

  const Gl* gl_ = nullptr;
  GLuint name_ = 0;
  std::size_t bytes_ = 0;
};

using GlBuffer = GlObject<&Gl::DeleteBuffers>;
using GlTexture = GlObject<&Gl::DeleteTextures>;
using GlFramebuffer = GlObject<&Gl::DeleteFramebuffers>;
using GlVertexArray = GlObject<&Gl::DeleteVertexArrays>;

/// Owns one linked program; move-only.
class GlProgram {
 public:
  GlProgram() = default;
  GlProgram(const Gl& gl, GLuint name) : gl_(&gl), name_(name) {}
  ~GlProgram() { reset(); }
  GlProgram(GlProgram&& other) noexcept : gl_(other.gl_), name_(std::exchange(other.name_, 0)) {}
  GlProgram& operator=(GlProgram&& other) noexcept {
    std::swap(gl_, other.gl_);
    std::swap(name_, other.name_);
    return *this;
  }
  GlProgram(const GlProgram&) = delete;
  GlProgram& operator=(const GlProgram&) = delete;

  GLuint name() const { return name_; }

 private:
  void reset() noexcept {
    if (name_ != 0) {
      gl_->DeleteProgram(name_);
    }
  }

  const Gl* gl_ = nullptr;
  GLuint name_ = 0;
};

/// Immutable storage of `bytes` bytes (at least 1) with `flags` as in glBufferStorage, filled
/// from `data` unless null. Throws std::runtime_error if the driver is out of memory.
GlBuffer makeBuffer(const Gl& gl, std::size_t bytes, const void* data, GLbitfield flags = 0);
GlVertexArray makeVertexArray(const Gl& gl);
GlFramebuffer makeFramebuffer(const Gl& gl);

}  // namespace limber::render
