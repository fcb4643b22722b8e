// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/render/gl_objects.h>

#include <array>
#include <cstddef>
#include <string>
#include <vector>

namespace limber::bench {

/// Compile-time options of a surface program, as in the renderer.
struct UnsharedVariant {
  bool smooth = false;
  bool twoSided = false;
  bool grid = false;
  bool shadows = false;
  bool textured = false;
};

/// A linked program and its uniforms.
struct UnsharedProgram {
  render::GlProgram program;
  GLint firstInstance = -1;
  GLint shapeRadius = -1;
};

/// Vertex attributes of all these programs.
enum UnsharedAttribute : GLuint { kPosition = 0, kTextureCoordinates = 1, kNormal = 2 };

/// Programs for complete vertices, each compiled on first use: vertex shaders of their own, and the
/// renderer's fragment shaders. Every function throws std::runtime_error if the driver rejects a shader.
class UnsharedPrograms {
 public:
  UnsharedPrograms(const render::Gl& gl, int shadowTaps) : gl_(gl), shadowTaps_(shadowTaps) {}

  const UnsharedProgram& surface(const UnsharedVariant& variant);
  const UnsharedProgram& depth();

 private:
  const render::Gl& gl_;
  int shadowTaps_;
  std::array<UnsharedProgram, 32> surfaces_;
  UnsharedProgram depth_;
};

}  // namespace limber::bench
