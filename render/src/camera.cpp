// SPDX-License-Identifier: Zlib
#include "limber/render/camera.h"

#include "frame_passes.h"
#include "limber/render/light.h"
#include "mat4.h"
#include "pixels.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <string>

namespace limber::render {
namespace {

constexpr float kMargin = 1.06f;
constexpr float kMinRadius = 1e-3f;

// The corners of a box relative to its centre, in view axes; z points to the eye.
using Corners = std::array<Vec3, 8>;

Corners cornersOf(Vec3 half, Vec3 right, Vec3 up, Vec3 back) {
  Corners corners;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Vec3 corner{(i & 1) != 0 ? half.x : -half.x, (i & 2) != 0 ? half.y : -half.y,
                      (i & 4) != 0 ? half.z : -half.z};
    corners[i] = {dot(corner, right), dot(corner, up), dot(corner, back)};
  }
  return corners;
}

// An eye at (e, d) sees corners with |c - e| <= (d - z) tan, so  e + d tan >= c + z tan  and  -e + d tan >=
// -c + z tan. Returns the smallest d, for which a suitable e exists.
float distanceFor(const Corners& corners, float Vec3::*axis, float tangent) {
  float low = 0.0f, high = 0.0f;
  for (const Vec3& corner : corners) {
    low = std::max(low, corner.z * tangent - corner.*axis);
    high = std::max(high, corner.z * tangent + corner.*axis);
  }
  return 0.5f * (low + high) / tangent;
}

// Returns the position on an axis from which both sides of the box appear under equal angles, by bisection.
float middleFor(const Corners& corners, float Vec3::*axis, float distance) {
  float low = -distance, high = distance;
  for (int i = 0; i < 24; ++i) {
    const float middle = 0.5f * (low + high);
    float below = 0.0f, above = 0.0f;
    for (const Vec3& corner : corners) {
      const float tangent = (corner.*axis - middle) / (distance - corner.z);
      below = std::max(below, -tangent);
      above = std::max(above, tangent);
    }
    (above > below ? low : high) = middle;
  }
  return 0.5f * (low + high);
}

Vec3 aboutVertical(Vec3 v, float c, float s) { return {c * v.x + s * v.z, v.y, c * v.z - s * v.x}; }

}  // namespace

Camera frameBox(Vec3 min, Vec3 max, Vec3 direction, float aspect) {
  Camera camera;
  const Vec3 back = unitOr(direction, {0.0f, 0.0f, 1.0f});
  if (std::abs(dot(back, camera.up)) > 0.999f) {
    camera.up = {0.0f, 0.0f, -1.0f};
  }
  const Vec3 right = unitOr(cross(camera.up, back), {1.0f, 0.0f, 0.0f});
  const Vec3 up = cross(back, right), half = 0.5f * (max - min);
  const Corners corners = cornersOf(half, right, up, back);
  const float tangent = std::tan(0.5f * camera.verticalFieldOfView) / kMargin;
  const float radius = std::max(length(half), kMinRadius);
  const float distance = std::max({distanceFor(corners, &Vec3::x, tangent * aspect),
                                   distanceFor(corners, &Vec3::y, tangent), 1.01f * radius});
  camera.target = 0.5f * (min + max) + middleFor(corners, &Vec3::x, distance) * right +
                  middleFor(corners, &Vec3::y, distance) * up;
  camera.eye = camera.target + distance * back;
  camera.nearPlane = std::max(0.2f * (distance - radius), 0.01f * radius);
  camera.farPlane = 20.0f * (distance + radius);
  return camera;
}

// Frames a square box around the circle in which the box rotates: its distance suits all sides.
Camera orbitBox(Vec3 min, Vec3 max, Vec3 direction, float aspect, float angle) {
  const Vec3 centre = 0.5f * (min + max);
  const float radius = 0.5f * std::hypot(max.x - min.x, max.z - min.z);
  Camera camera = frameBox({centre.x - radius, min.y, centre.z - radius},
                           {centre.x + radius, max.y, centre.z + radius}, direction, aspect);
  const float c = std::cos(angle), s = std::sin(angle);
  camera.eye = centre + aboutVertical(camera.eye - centre, c, s);
  camera.target = centre + aboutVertical(camera.target - centre, c, s);
  return camera;
}

Light lightBox(Vec3 min, Vec3 max, Light light) {
  light.shadowCentre = 0.5f * (min + max);
  light.shadowRadius = std::max(1.02f * 0.5f * length(max - min), 1e-3f);
  return light;
}

namespace {

// Radius of the shadow filter, texels.
constexpr float kShadowFilterReach = 1.8f;
// Depth of the shadow map's volume, in shadow radii.
constexpr float kShadowDepth = 4.0f;

FrameUniforms::Vec4 vec4(Vec3 v, float w = 0.0f) { return {v.x, v.y, v.z, w}; }

Vec3 linear(Vec3 srgb) { return {srgbToLinear(srgb.x), srgbToLinear(srgb.y), srgbToLinear(srgb.z)}; }

// Returns the matrix that maps the shadow sphere to [0, 1] in x and y, with y down like the rows of the map.
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

constexpr float kSunTangent = 0.07f;     // Of the sun's radius: a large lamp.
constexpr float kOcclusionReach = 0.3f;  // In shadow radii.

void addGalleryUniforms(FrameUniforms& uniforms, const Camera& camera, const Light& light,
                        const PictureSize& size) {
  const Vec3 forward = unitOr(camera.target - camera.eye, {0.0f, 0.0f, -1.0f});
  const Mat4 view = lookAlong(camera.eye, forward, camera.up);
  const float tanY = std::tan(0.5f * camera.verticalFieldOfView);
  const float tanX = tanY * static_cast<float>(size.width) / static_cast<float>(size.height);
  const float zNear = camera.nearPlane, zFar = camera.farPlane;
  const Vec3 right{view.at(0, 0), view.at(0, 1), view.at(0, 2)},
      up{view.at(1, 0), view.at(1, 1), view.at(1, 2)};
  // depth d = far / (far - near) - near far / ((far - near) z), see perspective()
  uniforms.forward = vec4(forward, zFar / (zNear - zFar));
  uniforms.right = vec4(tanX * right, zNear * zFar / (zNear - zFar));
  uniforms.down = vec4(-tanY * up, kOcclusionReach * light.shadowRadius);
  uniforms.shadowVolume = {2.0f * light.shadowRadius, kShadowDepth * light.shadowRadius,
                           static_cast<float>(size.shadowMapSize), kSunTangent};
  uniforms.stage = vec4(light.shadowCentre, light.shadowRadius);
}

void require(bool holds, const char* message) {
  if (!holds) {
    throw std::runtime_error(message);
  }
}

}  // namespace

void requireFinite(const char* field, float value) {
  if (!std::isfinite(value)) {
    throw std::runtime_error(std::string(field) + " is not finite");
  }
}

void requireFinite(const char* field, Vec3 value) {
  for (const float component : {value.x, value.y, value.z}) {
    requireFinite(field, component);
  }
}

void requireUsable(const Camera& camera, const Light& light, const DrawOptions& options) {
  requireFinite("camera.eye", camera.eye);
  requireFinite("camera.target", camera.target);
  requireFinite("camera.up", camera.up);
  requireFinite("camera.farPlane", camera.farPlane);
  require(length(camera.target - camera.eye) > 0.0f, "camera.target is camera.eye");
  require(camera.verticalFieldOfView > 0.0f && camera.verticalFieldOfView < kPi,
          "camera.verticalFieldOfView must be above 0 and below pi");
  require(camera.nearPlane > 0.0f && camera.nearPlane < camera.farPlane,
          "camera.nearPlane must be above 0 and below farPlane");
  requireFinite("light.towards", light.towards);
  requireFinite("light.sun", light.sun);
  requireFinite("light.sky", light.sky);
  requireFinite("light.ground", light.ground);
  requireFinite("light.shadowCentre", light.shadowCentre);
  requireFinite("light.shadowRadius", light.shadowRadius);
  requireFinite("options.hiddenOverlay", options.hiddenOverlay);
  requireFinite("options.backgroundTop", options.backgroundTop);
  requireFinite("options.backgroundBottom", options.backgroundBottom);
  require(options.strainRange > 0.0f && std::isfinite(options.strainRange),
          "options.strainRange must be above 0");
  require(options.lineWidth >= 0.0f && std::isfinite(options.lineWidth),
          "options.lineWidth must be 0 or more");
}

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
  // A texel is 2 radii / size wide; in units of the map's depth that is 2 / (kShadowDepth * size).
  uniforms.towardsLight =
      vec4(towards, kShadowFilterReach * 2.0f / (kShadowDepth * static_cast<float>(size.shadowMapSize)));
  uniforms.sun = vec4(light.sun);
  uniforms.sky = vec4(light.sky);
  uniforms.ground = vec4(light.ground);
  uniforms.backgroundTop = vec4(linear(options.backgroundTop));
  uniforms.backgroundBottom = vec4(linear(options.backgroundBottom));
  addGalleryUniforms(uniforms, camera, light, size);
  uniforms.viewport = {width, height, options.lineWidth, 1.0f / std::max(options.strainRange, 1e-6f)};
  return uniforms;
}

}  // namespace limber::render
