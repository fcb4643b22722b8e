// SPDX-License-Identifier: Zlib
#include "unshared_programs.h"

namespace limber::bench {
namespace {

using namespace render;

constexpr const char* kVertexShader = R"glsl(
layout(location = 0) in vec4 vertexPosition;
layout(location = 1) in vec2 vertexUv;
layout(location = 2) in vec3 vertexNormal;

layout(std430, binding = 2) readonly buffer Instances { vec4 instances[]; };  // Two each: colour and layer, material.

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
  look = instances[2u * firstInstance];
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

}  // namespace

const ShaderProgram& UnsharedPrograms::surface(const SurfaceVariant& variant) {
  ShaderProgram& program = surfaces_[indexOf(variant)];
  if (program.name() == 0) {
    const ShaderText normal =
        variant.smooth ? ShaderText("shading_normal.glsl") : ShaderText("flat normal", kFlatNormal);
    program =
        buildProgram(gl_,
                     {{GL_VERTEX_SHADER, {"frame.glsl", {"unshared vertices", kVertexShader}}},
                      {GL_FRAGMENT_SHADER,
                       {"frame.glsl", "background.glsl", normal, "surface_colour.glsl", "surface.frag"}}},
                     definesOf(variant, shadowTaps_));
  }
  return program;
}

const ShaderProgram& UnsharedPrograms::depth() {
  if (depth_.name() == 0) {
    depth_ = buildProgram(gl_,
                          {{GL_VERTEX_SHADER, {"frame.glsl", {"unshared depth", kDepthVertexShader}}},
                           {GL_FRAGMENT_SHADER, {"depth.frag"}}},
                          {});
  }
  return depth_;
}

}  // namespace limber::bench
