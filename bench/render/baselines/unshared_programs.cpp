// SPDX-License-Identifier: Zlib
#include "unshared_programs.h"

#include "program_set.h"

#include <stdexcept>

namespace limber::bench {
namespace {

using namespace render;

constexpr const char* kVertexShader = R"glsl(
layout(location = 0) in vec4 vertexPosition;
layout(location = 1) in vec2 vertexUv;
layout(location = 2) in vec3 vertexNormal;

layout(std430, binding = 2) readonly buffer Instances { vec4 instances[]; };  // Colour, texture layer.

out vec3 toEye;
out vec3 shadowCoord;
out vec2 uv;
flat out vec4 look;
out vec3 smoothNormal;

void main() {
  vec3 position = vertexPosition.xyz;
  smoothNormal = vertexNormal;
  toEye = frame.eye.xyz - position;
  shadowCoord = (frame.worldToShadow * vec4(position, 1.0)).xyz;
  uv = vertexUv;
  look = instances[firstInstance];
  gl_Position = frame.viewProjection * vec4(position, 1.0);
}
)glsl";

constexpr const char* kDepthVertexShader = R"glsl(
layout(location = 0) in vec4 vertexPosition;

void main() {
  vec3 shadow = (frame.worldToShadow * vec4(vertexPosition.xyz, 1.0)).xyz;
  gl_Position = vec4(2.0 * shadow.x - 1.0, 1.0 - 2.0 * shadow.y, shadow.z, 1.0);
}
)glsl";

// In place of the renderer's shading_normal.glsl, whose flat shapes have no normals at their vertices.
constexpr const char* kFlatNormal = R"glsl(
in vec3 toEye;
in vec3 smoothNormal;

vec3 shadingNormal() {
  vec3 normal = normalize(smoothNormal);
#ifdef TWO_SIDED
  normal = gl_FrontFacing ? normal : -normal;
#endif
  return normal;
}
)glsl";

void attach(const Gl& gl, GLuint program, GLenum stage, const std::string& text) {
  const GLuint shader = gl.CreateShader(stage);
  const char* start = text.c_str();
  gl.ShaderSource(shader, 1, &start, nullptr);
  gl.CompileShader(shader);
  GLint compiled = GL_FALSE;
  gl.GetShaderiv(shader, GL_COMPILE_STATUS, &compiled);
  std::array<char, 4096> log{};
  gl.GetShaderInfoLog(shader, static_cast<GLsizei>(log.size()), nullptr, log.data());
  gl.AttachShader(program, shader);
  gl.DeleteShader(shader);  // The program keeps it.
  if (compiled != GL_TRUE) {
    throw std::runtime_error(std::string("cannot compile a shader of the unshared bodies: ") + log.data());
  }
}

UnsharedProgram build(const Gl& gl, const std::string& vertexText, const std::string& fragmentText) {
  UnsharedProgram built;
  built.program = GlProgram(gl, gl.CreateProgram());
  const GLuint name = built.program.name();
  attach(gl, name, GL_VERTEX_SHADER, vertexText);
  attach(gl, name, GL_FRAGMENT_SHADER, fragmentText);
  gl.LinkProgram(name);
  GLint linked = GL_FALSE;
  gl.GetProgramiv(name, GL_LINK_STATUS, &linked);
  if (linked != GL_TRUE) {
    std::array<char, 4096> log{};
    gl.GetProgramInfoLog(name, static_cast<GLsizei>(log.size()), nullptr, log.data());
    throw std::runtime_error(std::string("cannot link a program of the unshared bodies: ") + log.data());
  }
  built.firstInstance = gl.GetUniformLocation(name, "firstInstance");
  built.shapeRadius = gl.GetUniformLocation(name, "shapeRadius");
  return built;
}

std::size_t indexOf(const UnsharedVariant& variant) {
  std::size_t index = 0;
  for (const bool bit : {variant.smooth, variant.twoSided, variant.grid, variant.shadows, variant.textured}) {
    index = 2 * index + (bit ? 1 : 0);
  }
  return index;
}

/// The start of each shader: version, definitions and the data of the frame.
std::string header(const UnsharedVariant& variant, int shadowTaps) {
  std::string text = "#version 450 core\n#define SHADOW_TAPS " + std::to_string(shadowTaps) + "\n";
  const auto define = [&text](bool wanted, const char* name) {
    if (wanted) {
      text += std::string("#define ") + name + "\n";
    }
  };
  define(variant.smooth, "SMOOTH");
  define(variant.twoSided, "TWO_SIDED");
  define(variant.grid, "GRID");
  define(variant.shadows, "SHADOWS");
  define(variant.textured, "TEXTURED");
  return text + shaderSource("frame.glsl");
}

}  // namespace

const UnsharedProgram& UnsharedPrograms::surface(const UnsharedVariant& variant) {
  UnsharedProgram& program = surfaces_[indexOf(variant)];
  if (program.program.name() == 0) {
    const std::string start = header(variant, shadowTaps_);
    const char* normal = variant.smooth ? shaderSource("shading_normal.glsl") : kFlatNormal;
    program = build(gl_, start + kVertexShader,
                    start + shaderSource("background.glsl") + normal + shaderSource("surface.frag"));
  }
  return program;
}

const UnsharedProgram& UnsharedPrograms::depth() {
  if (depth_.program.name() == 0) {
    const std::string start = header({}, shadowTaps_);
    depth_ = build(gl_, start + kDepthVertexShader, start + shaderSource("depth.frag"));
  }
  return depth_;
}

}  // namespace limber::bench
