// SPDX-License-Identifier: Zlib
#include "limber/render/gl_debug_messages.h"

namespace limber::render {

DebugMessages::DebugMessages(const Gl& gl) : gl_(gl) {
  gl_.Enable(GL_DEBUG_OUTPUT);
  // Synchronous, so that counts are complete when a call returns and no other thread writes them.
  gl_.Enable(GL_DEBUG_OUTPUT_SYNCHRONOUS);
  gl_.DebugMessageCallback(&DebugMessages::receive, this);
}

DebugMessages::~DebugMessages() { gl_.DebugMessageCallback(nullptr, nullptr); }

void APIENTRY DebugMessages::receive(GLenum, GLenum, GLuint, GLenum severity, GLsizei length,
                                     const GLchar* text, const void* self) {
  // The C interface hands our own pointer back as const.
  auto& messages = *static_cast<DebugMessages*>(const_cast<void*>(self));
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
