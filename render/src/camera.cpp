// SPDX-License-Identifier: Zlib
#include "limber/render/camera.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "mat4.h"

namespace limber::render {
namespace {

constexpr float kMargin = 1.06f;
constexpr float kSmallestRadius = 1e-3f;

// How far from the centre the eye must be so that a corner (relative to the centre, in view axes)
// lies inside a view frustum with these tangents.
float distanceFor(Vec3 corner, float tanX, float tanY) {
  return corner.z + std::max(std::abs(corner.x) / tanX, std::abs(corner.y) / tanY);
}

}  // namespace

Camera frameBox(Vec3 min, Vec3 max, Vec3 direction, float aspect) {
  Camera camera;
  const Vec3 back = unitOr(direction, {0.0f, 0.0f, 1.0f});
  const Vec3 centre = 0.5f * (min + max);
  const Vec3 half = 0.5f * (max - min);
  if (std::abs(dot(back, camera.up)) > 0.999f) {
    camera.up = {0.0f, 0.0f, -1.0f};
  }
  const Vec3 right = unitOr(cross(camera.up, back), {1.0f, 0.0f, 0.0f});
  const Vec3 up = cross(back, right);
  const float tanY = std::tan(0.5f * camera.verticalFieldOfView) / kMargin;
  float distance = 0.0f;
  for (int i = 0; i < 8; ++i) {
    const Vec3 corner{(i & 1) != 0 ? half.x : -half.x, (i & 2) != 0 ? half.y : -half.y,
                      (i & 4) != 0 ? half.z : -half.z};
    const Vec3 inView{dot(corner, right), dot(corner, up), dot(corner, back)};
    distance = std::max(distance, distanceFor(inView, tanY * aspect, tanY));
  }
  const float radius = std::max(length(half), kSmallestRadius);
  distance = std::max(distance, 1.01f * radius);
  camera.target = centre;
  camera.eye = centre + distance * back;
  camera.nearPlane = std::max(0.2f * (distance - radius), 0.01f * radius);
  camera.farPlane = 20.0f * (distance + radius);
  return camera;
}

// The box that is as wide as the circle it turns in is seen from all sides at the distance at which it is
// seen from one.
Camera orbitBox(Vec3 min, Vec3 max, Vec3 direction, float aspect, float turn) {
  const Vec3 centre = 0.5f * (min + max);
  const float reach = 0.5f * std::hypot(max.x - min.x, max.z - min.z);
  Camera camera = frameBox({centre.x - reach, min.y, centre.z - reach},
                           {centre.x + reach, max.y, centre.z + reach}, direction, aspect);
  const Vec3 arm = camera.eye - centre;
  const float c = std::cos(turn), s = std::sin(turn);
  camera.eye = centre + Vec3{c * arm.x + s * arm.z, arm.y, c * arm.z - s * arm.x};
  return camera;
}

}  // namespace limber::render
