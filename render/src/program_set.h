// SPDX-License-Identifier: Zlib
#pragma once

#include "limber/render/gl_objects.h"
#include "limber/render/legend.h"

#include <array>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace limber::render {

/// Text of a file of the shaders folder, compiled into the library.
const char* shaderSource(std::string_view name);

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

/// Where a surface's vertices come from.
enum class VertexSource {
  Mesh,     ///< Vertices with texture coordinates that ride on points.
  Welded,   ///< The points themselves: where nothing asks for texture coordinates.
  Tube,     ///< Made along a polyline.
  Unshared  ///< Whole, of StreamPath::Unshared.
};
constexpr std::size_t kVertexSources = 4;

/// What a surface program is specialised for; a software rasteriser runs both sides
/// of every branch.
struct SurfaceVariant {
  VertexSource source = VertexSource::Mesh;
  bool smooth = false;
  bool twoSided = false;
  bool grid = false;
  bool shadows = false;
  bool textured = false;
};

/// All programs, each compiled when it is first asked for. Every function throws
/// std::runtime_error if the driver rejects a shader.
class ProgramSet {
 public:
  ProgramSet(const Gl& gl, int shadowTaps) : gl_(gl), shadowTaps_(shadowTaps) {}

  const ShaderProgram& surface(const SurfaceVariant& variant);
  const ShaderProgram& depth(VertexSource source);
  const ShaderProgram& lines();
  const ShaderProgram& overlay(bool onScreen);
  const ShaderProgram& backdrop();
  const ShaderProgram& legend(ColourMap map);
  const ShaderProgram& normals(bool tube);
  const ShaderProgram& skin(bool dense);

 private:
  const Gl& gl_;
  int shadowTaps_;
  std::array<ShaderProgram, 32 * kVertexSources> surfaces_;
  std::array<ShaderProgram, kVertexSources> depths_;
  std::array<ShaderProgram, 2> normals_;
  std::array<ShaderProgram, 2> skins_;
  ShaderProgram lines_;
  std::array<ShaderProgram, 2> overlays_;
  ShaderProgram backdrop_;
  std::array<ShaderProgram, 2> legends_;
};

}  // namespace limber::render
