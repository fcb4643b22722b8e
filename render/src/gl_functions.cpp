// SPDX-License-Identifier: Zlib
#include "limber/render/gl_functions.h"

#include "limber/render/gl_context.h"
#include "limber/render/gl_debug_messages.h"
#include "limber/render/gl_objects.h"

#include <algorithm>
#include <array>
#include <stdexcept>
#include <string>
#include <string_view>

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

// OpenGL 4.5 allows drivers without storage buffers in the vertex stage.
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
  // An old version is a better explanation than the names of missing functions.
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

bool isSoftwareRasteriser(const Gl& gl) { return isSoftwareRasteriser(text(gl, GL_RENDERER)); }

bool isSoftwareRasteriser(std::string_view renderer) {
  constexpr std::array<std::string_view, 5> kNames{"llvmpipe", "softpipe", "swrast", "SwiftShader",
                                                   "Software"};
  return std::any_of(kNames.begin(), kNames.end(), [renderer](std::string_view name) {
    return renderer.find(name) != std::string_view::npos;
  });
}

std::string takeGlErrors(const Gl& gl) {
  std::string errors;
  // The loop is bounded, because a lost context returns errors for ever.
  for (int i = 0; i < 8; ++i) {
    const GLenum error = gl.GetError();
    if (error == GL_NO_ERROR) {
      break;
    }
    errors += std::string(" ") + errorName(error);
  }
  return errors;
}

void checkGlErrors(const Gl& gl, const char* where) {
  const std::string errors = takeGlErrors(gl);
  if (!errors.empty()) {
    throw std::runtime_error(std::string(where) + ":" + errors);
  }
}

GlBuffer makeBuffer(const Gl& gl, std::size_t bytes, const void* data, GLbitfield flags) {
  GLuint name = 0;
  gl.CreateBuffers(1, &name);
  const std::size_t size = std::max<std::size_t>(bytes, 1);
  GlBuffer buffer(gl, name, size);
  takeGlErrors(gl);
  gl.NamedBufferStorage(name, static_cast<GLsizeiptr>(size), data, flags);
  if (!takeGlErrors(gl).empty()) {
    throw std::runtime_error("the driver refused a buffer of " + std::to_string(size) + " bytes");
  }
  return buffer;
}

GlVertexArray makeVertexArray(const Gl& gl) {
  GLuint name = 0;
  gl.CreateVertexArrays(1, &name);
  return {gl, name};
}

GlFramebuffer makeFramebuffer(const Gl& gl) {
  GLuint name = 0;
  gl.CreateFramebuffers(1, &name);
  return {gl, name};
}

DebugMessages::DebugMessages(const Gl& gl) : gl_(gl) {
  gl_.Enable(GL_DEBUG_OUTPUT);
  // Synchronous: the counts are complete when a call returns, and no other thread changes them.
  gl_.Enable(GL_DEBUG_OUTPUT_SYNCHRONOUS);
  gl_.DebugMessageCallback(&DebugMessages::receive, this);
}

DebugMessages::~DebugMessages() { gl_.DebugMessageCallback(nullptr, nullptr); }

void APIENTRY DebugMessages::receive(GLenum, GLenum type, GLuint, GLenum severity, GLsizei length,
                                     const GLchar* text, const void* self) {
  // The C interface passes our pointer as const.
  auto& messages = *static_cast<DebugMessages*>(const_cast<void*>(self));
  const bool isGrave = severity == GL_DEBUG_SEVERITY_HIGH || severity == GL_DEBUG_SEVERITY_MEDIUM;
  if (isGrave && type == GL_DEBUG_TYPE_PERFORMANCE) {
    ++messages.counts_.performance;
    return;
  }
  switch (severity) {
    case GL_DEBUG_SEVERITY_HIGH:
      ++messages.counts_.high;
      break;
    case GL_DEBUG_SEVERITY_MEDIUM:
      ++messages.counts_.medium;
      break;
    case GL_DEBUG_SEVERITY_LOW:
      ++messages.counts_.low;
      return;
    default:
      ++messages.counts_.notification;
      return;
  }
  messages.lastComplaint_ = length < 0 ? text : std::string(text, static_cast<std::size_t>(length));
}

}  // namespace limber::render
