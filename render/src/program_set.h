// SPDX-License-Identifier: Zlib
#pragma once

#include "limber/render/gl_objects.h"
#include "limber/render/legend.h"
#include "limber/render/renderer.h"

#include <array>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace limber::render {

/// Returns the text of a file of the folder `shaders`, which is compiled into the library.
const char* shaderSource(std::string_view name);

/// Uniforms that change with each draw or dispatch.
enum class DrawUniform {
  FirstPoint,
  FirstInstance,
  PointCount,
  FirstNormal,
  NormalCount,
  FirstPlace,
  PlaceCount,
  Invocations,
  ShapeRadius,
  Opacity,
  Rectangle,
  Count
};

/// A linked program and the locations of its uniforms.
struct ShaderProgram {
  GlProgram program;
  /// -1 if the program does not use the uniform; OpenGL ignores writes to -1.
  std::array<GLint, static_cast<std::size_t>(DrawUniform::Count)> locations{};

  GLuint name() const { return program.name(); }
  GLint location(DrawUniform uniform) const { return locations[static_cast<std::size_t>(uniform)]; }
};

/// A named piece of shader source: a file of the folder `shaders`, or another text, which must outlive it.
struct ShaderText {
  ShaderText(const char* file) : name(file), text(shaderSource(file)) {}
  ShaderText(std::string_view n, const char* t) : name(n), text(t) {}

  std::string_view name;
  const char* text;
};

struct StageSource {
  GLenum stage = 0;
  std::vector<ShaderText> files;  ///< Concatenated in this order, after #version and #defines.
};

/// Compiles and links a program. Throws std::runtime_error with the compiler's log and the names of the
/// files.
ShaderProgram buildProgram(const Gl& gl, const std::vector<StageSource>& stages,
                           const std::vector<std::string>& defines);

/// Source of a surface's vertices.
enum class VertexSource {
  Mesh,    ///< Vertices with texture coordinates, at points.
  Welded,  ///< The points themselves, for programs without texture coordinates.
  Tube     ///< Computed along a polyline.
};
constexpr std::size_t kVertexSources = 3;

/// Compile-time options of a surface program. They are no branches in the shader, because a software
/// rasteriser runs both sides of a branch.
struct SurfaceVariant {
  VertexSource source = VertexSource::Mesh;
  bool smooth = false;
  bool twoSided = false;
  bool grid = false;
  bool shadows = false;
  bool textured = false;
};

/// Returns a number below 32 * kVertexSources; below 32 for meshes.
std::size_t indexOf(const SurfaceVariant& variant);

/// Returns the definitions with which the shaders of a surface are compiled.
std::vector<std::string> definesOf(const SurfaceVariant& variant, int shadowTaps);

/// All programs, each compiled on first use. Every function throws std::runtime_error if the driver rejects a
/// shader.
class ProgramSet {
 public:
  ProgramSet(const Gl& gl, int shadowTaps, Quality quality)
      : gl_(gl), shadowTaps_(shadowTaps), gallery_(quality == Quality::Gallery) {}

  const ShaderProgram& surface(const SurfaceVariant& variant);
  /// Depth alone, seen from the light or from the eye.
  const ShaderProgram& depth(VertexSource source, bool fromEye = false);
  const ShaderProgram& lines();
  const ShaderProgram& overlay(bool onScreen);
  const ShaderProgram& backdrop();
  const ShaderProgram& occlusion();
  const ShaderProgram& occlusionBlur();
  const ShaderProgram& legend(ColourMap map);
  const ShaderProgram& normals(bool tube);
  const ShaderProgram& skin(bool dense);

 private:
  const Gl& gl_;
  int shadowTaps_;
  bool gallery_;
  std::array<ShaderProgram, 32 * kVertexSources> surfaces_;
  std::array<ShaderProgram, 2 * kVertexSources> depths_;
  std::array<ShaderProgram, 2> normals_;
  std::array<ShaderProgram, 2> skins_;
  ShaderProgram lines_;
  std::array<ShaderProgram, 2> overlays_;
  ShaderProgram backdrop_;
  ShaderProgram occlusion_;
  ShaderProgram occlusionBlur_;
  std::array<ShaderProgram, 2> legends_;
};

}  // namespace limber::render
