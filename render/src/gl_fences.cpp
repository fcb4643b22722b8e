// SPDX-License-Identifier: Zlib
#include "gl_fences.h"

#include <stdexcept>

namespace limber::render {

FenceSource::Fence GlFences::insert() {
  const GLsync sync = gl_.FenceSync(GL_SYNC_GPU_COMMANDS_COMPLETE, 0);
  if (sync == nullptr) {
    throw std::runtime_error("glFenceSync failed: the OpenGL context is lost or not current");
  }
  return sync;
}

bool GlFences::wait(Fence fence, std::chrono::nanoseconds timeout) {
  // Without the flush the fence could sit in an unsent command buffer and never pass.
  const GLenum result = gl_.ClientWaitSync(static_cast<GLsync>(fence), GL_SYNC_FLUSH_COMMANDS_BIT,
                                           static_cast<GLuint64>(timeout.count()));
  if (result == GL_WAIT_FAILED) {
    throw std::runtime_error("glClientWaitSync failed: the OpenGL context is lost or not current");
  }
  return result != GL_TIMEOUT_EXPIRED;
}

void GlFences::destroy(Fence fence) noexcept { gl_.DeleteSync(static_cast<GLsync>(fence)); }

}  // namespace limber::render
