// SPDX-License-Identifier: Zlib
#include "limber/render/gl_objects.h"

#include <algorithm>
#include <stdexcept>
#include <string>

namespace limber::render {

GlBuffer makeBuffer(const Gl& gl, std::size_t bytes, const void* data, GLbitfield flags) {
  GLuint name = 0;
  gl.CreateBuffers(1, &name);
  const std::size_t size = std::max<std::size_t>(bytes, 1);
  GlBuffer buffer(gl, name, size);
  // Errors left by others must not be taken for ours.
  while (gl.GetError() != GL_NO_ERROR) {
  }
  gl.NamedBufferStorage(name, static_cast<GLsizeiptr>(size), data, flags);
  if (gl.GetError() != GL_NO_ERROR) {
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

}  // namespace limber::render
