// SPDX-License-Identifier: Zlib
#pragma once

#include "limber/render/vec3.h"

namespace limber::render {

/// Perspective camera. Metres and radians.
struct Camera {
  Vec3 eye{4.0f, 3.0f, 6.0f};
  Vec3 target{0.0f, 0.0f, 0.0f};
  Vec3 up{0.0f, 1.0f, 0.0f};         ///< Not parallel to target - eye.
  float verticalFieldOfView = 0.7f;  ///< Full angle.
  float nearPlane = 0.05f;
  float farPlane = 200.0f;
};

/// Returns a camera that sees all of a bounding box from as near as possible, with equal room on opposite
/// sides. `direction` points from the scene to the camera and need not be a unit vector. `aspect` is width /
/// height.
Camera frameBox(Vec3 min, Vec3 max, Vec3 direction, float aspect);

/// Returns this camera rotated by `angle` (radians) about the vertical axis through the centre of the box.
/// From its distance all of the box is visible at every angle.
Camera orbitBox(Vec3 min, Vec3 max, Vec3 direction, float aspect, float angle);

}  // namespace limber::render
