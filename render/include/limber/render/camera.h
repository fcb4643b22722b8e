// SPDX-License-Identifier: Zlib
#pragma once

#include "limber/render/vec3.h"

namespace limber::render {

/// Perspective camera. Metres and radians.
struct Camera {
  Vec3 eye{4.0f, 3.0f, 6.0f};
  Vec3 target{0.0f, 0.0f, 0.0f};
  Vec3 up{0.0f, 1.0f, 0.0f};         ///< Not parallel to target - eye.
  float verticalFieldOfView = 0.7f;  ///< Whole angle.
  float nearPlane = 0.05f;
  float farPlane = 200.0f;
};

/// The camera that looks along -`direction` (which points from the scene to the camera and need
/// not be a unit vector) at a bounding box and sees all of it. `aspect` is width / height.
Camera frameBox(Vec3 min, Vec3 max, Vec3 direction, float aspect);

/// The same turned by `turn` (radians) about the vertical through the box's middle, from a distance at which
/// all of the box is seen from all sides.
Camera orbitBox(Vec3 min, Vec3 max, Vec3 direction, float aspect, float turn);

}  // namespace limber::render
