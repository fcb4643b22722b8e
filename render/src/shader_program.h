// SPDX-License-Identifier: Zlib
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "limber/render/gl_objects.h"

namespace limber::render {

/// What changes from one draw or dispatch to the next.
enum class DrawUniform {
  FirstPoint,
  FirstInstance,
  PointCount,
  FirstNormal,
  FirstPlace,
  PlaceCount,
  Invocations,
  ShapeRadius,
  Opacity,
  Place,
  Count
};

/// A linked program and where its uniforms are.
struct ShaderProgram {
  GlProgram program;
  /// -1 where the program does not use the uniform; OpenGL ignores writes to that.
  std::array<GLint, static_cast<std::size_t>(DrawUniform::Count)> locations{};

  GLuint name() const { return program.name(); }
  GLint location(DrawUniform uniform) const { return locations[static_cast<std::size_t>(uniform)]; }
};

struct StageSource {
  GLenum stage = 0;
  std::vector<std::string_view> files;  ///< Joined in this order, after the #version and #defines.
};

/// Throws std::runtime_error with the compiler's log and the names of the files.
ShaderProgram buildProgram(const Gl& gl, const std::vector<StageSource>& stages,
                           const std::vector<std::string>& defines);

}  // namespace limber::render
