// SPDX-License-Identifier: Zlib
#include "frame_uniforms.h"

#include <algorithm>

#include "srgb.h"

namespace limber::render {
namespace {

// How far the shadow filter reaches, in texels.
constexpr float kShadowFilterReach = 1.8f;
// Depth covered by the shadow map, in shadow radii.
constexpr float kShadowDepth = 4.0f;

FrameUniforms::Vec4 vec4(Vec3 v, float w = 0.0f) { return {v.x, v.y, v.z, w}; }

Vec3 linear(Vec3 srgb) { return {srgbToLinear(srgb.x), srgbToLinear(srgb.y), srgbToLinear(srgb.z)}; }

// To [0, 1] in all three axes inside the shadow sphere, y down as the map's rows are.
Mat4 worldToShadow(const Light& light, Vec3 towards) {
  const float radius = std::max(light.shadowRadius, 1e-6f);
  const Vec3 eye = light.shadowCentre + (0.5f * kShadowDepth * radius) * towards;
  const Mat4 view = lookAlong(eye, -1.0f * towards, {0.0f, 1.0f, 0.0f});
  Mat4 scale;
  scale.at(0, 0) = 0.5f / radius;
  scale.at(1, 1) = -0.5f / radius;
  scale.at(2, 2) = -1.0f / (kShadowDepth * radius);
  scale.at(0, 3) = 0.5f;
  scale.at(1, 3) = 0.5f;
  scale.at(3, 3) = 1.0f;
  return scale * view;
}

}  // namespace

FrameUniforms makeFrameUniforms(const Camera& camera, const Light& light, const DrawOptions& options,
                                const PictureSize& size) {
  const auto width = static_cast<float>(size.width);
  const auto height = static_cast<float>(size.height);
  const Vec3 towards = unitOr(light.towards, {0.0f, 1.0f, 0.0f});
  const Vec3 forward = unitOr(camera.target - camera.eye, {0.0f, 0.0f, -1.0f});
  FrameUniforms uniforms;
  uniforms.viewProjection =
      perspective(camera.verticalFieldOfView, width / height, camera.nearPlane, camera.farPlane) *
      lookAlong(camera.eye, forward, camera.up);
  uniforms.worldToShadow = worldToShadow(light, towards);
  uniforms.eye = vec4(camera.eye);
  // A texel is 2 radii / size wide; measured in the map's depth that is 2 / (kShadowDepth * size).
  uniforms.towardsLight =
      vec4(towards, kShadowFilterReach * 2.0f / (kShadowDepth * static_cast<float>(size.shadowMapSize)));
  uniforms.sun = vec4(light.sun);
  uniforms.sky = vec4(light.sky);
  uniforms.ground = vec4(light.ground);
  uniforms.backgroundTop = vec4(linear(options.backgroundTop));
  uniforms.backgroundBottom = vec4(linear(options.backgroundBottom));
  uniforms.viewport = {width, height, options.lineWidth, 1.0f / std::max(options.strainRange, 1e-6f)};
  return uniforms;
}

}  // namespace limber::render
