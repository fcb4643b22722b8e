// SPDX-License-Identifier: Zlib
#include "limber/render/gl_functions.h"

#include <array>
#include <stdexcept>
#include <string_view>

#include "limber/render/gl_context.h"

namespace limber::render {
namespace {

std::string text(const Gl& gl, GLenum what) {
  const GLubyte* found = gl.GetString(what);
  return found == nullptr ? "?" : reinterpret_cast<const char*>(found);
}

GLint integer(const Gl& gl, GLenum what) {
  GLint value = 0;
  gl.GetIntegerv(what, &value);
  return value;
}

void requireVersion(const Gl& gl) {
  const GLint major = integer(gl, GL_MAJOR_VERSION);
  const GLint minor = integer(gl, GL_MINOR_VERSION);
  if (major < 4 || (major == 4 && minor < 5)) {
    throw std::runtime_error("OpenGL 4.5 is needed, but this driver has " + std::to_string(major) + "." +
                             std::to_string(minor) + ": " + describeDriver(gl));
  }
}

// 4.5 allows a driver to offer no storage buffers at all in the vertex stage.
void requireVertexStorageBuffers(const Gl& gl) {
  constexpr GLint kNeeded = 4;
  const GLint blocks = integer(gl, GL_MAX_VERTEX_SHADER_STORAGE_BLOCKS);
  if (blocks < kNeeded) {
    throw std::runtime_error("the vertex stage needs " + std::to_string(kNeeded) +
                             " storage buffers, but this driver has " + std::to_string(blocks) + ": " +
                             describeDriver(gl));
  }
}

const char* errorName(GLenum error) {
  switch (error) {
    case GL_INVALID_ENUM:
      return "GL_INVALID_ENUM";
    case GL_INVALID_VALUE:
      return "GL_INVALID_VALUE";
    case GL_INVALID_OPERATION:
      return "GL_INVALID_OPERATION";
    case GL_INVALID_FRAMEBUFFER_OPERATION:
      return "GL_INVALID_FRAMEBUFFER_OPERATION";
    case GL_OUT_OF_MEMORY:
      return "GL_OUT_OF_MEMORY";
    default:
      return "unknown OpenGL error";
  }
}

}  // namespace

Gl loadGl(const GlContext& context) {
  Gl gl;
  std::string missing;
#define LIMBER_GL_LOAD(name, TYPE)                                                   \
  gl.name = reinterpret_cast<PFNGL##TYPE##PROC>(context.getProcAddress("gl" #name)); \
  if (gl.name == nullptr) missing += " gl" #name;
  LIMBER_GL_FUNCTIONS(LIMBER_GL_LOAD)
#undef LIMBER_GL_LOAD
  // The version explains missing functions better than their names do.
  if (gl.GetString != nullptr && gl.GetIntegerv != nullptr) {
    requireVersion(gl);
  }
  if (!missing.empty()) {
    throw std::runtime_error("context " + context.name() + " lacks" + missing);
  }
  requireVertexStorageBuffers(gl);
  return gl;
}

std::string describeDriver(const Gl& gl) {
  return text(gl, GL_VENDOR) + " / " + text(gl, GL_RENDERER) + " / " + text(gl, GL_VERSION);
}

void checkGlErrors(const Gl& gl, const char* where) {
  std::string errors;
  // Bounded, because a lost context reports an error forever.
  for (int i = 0; i < 8; ++i) {
    const GLenum error = gl.GetError();
    if (error == GL_NO_ERROR) {
      break;
    }
    errors += std::string(" ") + errorName(error);
  }
  if (!errors.empty()) {
    throw std::runtime_error(std::string(where) + ":" + errors);
  }
}

}  // namespace limber::render
