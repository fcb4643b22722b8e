// SPDX-License-Identifier: Zlib
#pragma once

#include "program_set.h"

#include <array>

namespace limber::bench {

/// Vertex attributes of all these programs.
enum UnsharedAttribute : GLuint { kPosition = 0, kTextureCoordinates = 1, kNormal = 2 };

/// Programs for complete vertices, each compiled on first use: vertex shaders of their own, and the
/// renderer's fragment shaders. Every function throws std::runtime_error if the driver rejects a shader.
class UnsharedPrograms {
 public:
  UnsharedPrograms(const render::Gl& gl, int shadowTaps) : gl_(gl), shadowTaps_(shadowTaps) {}

  const render::ShaderProgram& surface(const render::SurfaceVariant& variant);  ///< Of a mesh.
  const render::ShaderProgram& depth();

 private:
  const render::Gl& gl_;
  int shadowTaps_;
  std::array<render::ShaderProgram, 32> surfaces_;
  render::ShaderProgram depth_;
};

}  // namespace limber::bench
