// SPDX-License-Identifier: Zlib
#pragma once

#include "limber/render/gl_functions.h"

#include <cstddef>
#include <string>

namespace limber::render {

/// Number of the driver's debug messages, by severity; those about performance are counted apart.
struct DebugMessageCounts {
  std::size_t high = 0;
  std::size_t medium = 0;
  std::size_t low = 0;
  std::size_t notification = 0;
  std::size_t performance = 0;  ///< of medium and high severity; NVIDIA's drivers tell about each buffer that
                                ///< is read back
};

/// Receives the driver's debug messages from construction on. It must outlive all use of the context, or be
/// destroyed while the context is current. It cannot be moved or copied, because the driver keeps its
/// address. At most one per context.
class DebugMessages {
 public:
  explicit DebugMessages(const Gl& gl);
  ~DebugMessages();
  DebugMessages(const DebugMessages&) = delete;
  DebugMessages& operator=(const DebugMessages&) = delete;

  const DebugMessageCounts& counts() const { return counts_; }
  /// Number of messages of medium or high severity that are not about performance; 0 in a correct program.
  std::size_t complaints() const { return counts_.medium + counts_.high; }
  /// Text of the last of these messages, else empty.
  const std::string& lastComplaint() const { return lastComplaint_; }

 private:
  static void APIENTRY receive(GLenum source, GLenum type, GLuint id, GLenum severity, GLsizei length,
                               const GLchar* text, const void* self);

  const Gl& gl_;
  DebugMessageCounts counts_;
  std::string lastComplaint_;
};

}  // namespace limber::render
