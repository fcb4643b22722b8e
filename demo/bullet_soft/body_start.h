// SPDX-License-Identifier: Zlib
#pragma once

#include "scenes/scene.h"

#include <limber/soft_body_settings.h>

#include <btBulletDynamicsCommon.h>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <cstdint>
#include <vector>

// What Bullet's own soft bodies need to know of one of Limber's.

namespace limber::bullet_soft {

/// A body of point masses and springs, described for all engines.
struct BodySetup {
  SharedNetwork network;
  SoftBodySettings settings;  ///< stiffness, mass, damping and position; each engine has its own stepping
  std::vector<std::uint32_t> pins;  ///< points that are held at their initial positions
  Eigen::Matrix3Xd positions;       ///< 3 x #points, m, or empty: from the settings
  Eigen::Matrix3Xd velocities;      ///< 3 x #points, m/s, or empty: from the settings
  double drag = 0.0;                ///< 1/s, slows all motion in engines without dampers along springs
  bool maySleep = false;            ///< if the engine supports it; otherwise the body is kept awake
};

/// The initial state of a body and the constants of its springs, computed from a set-up as Limber does, for
/// other engines.
struct BodyStart {
  Eigen::Matrix3Xd positions, velocities;  ///< 3 x #points
  Eigen::VectorXd masses;                  ///< #points, kg, also for pinned points
  Eigen::VectorXd restLengths;             ///< #springs, m
  Eigen::VectorXd stiffnesses;             ///< #springs, N/m
  Eigen::VectorXd dampings;                ///< #springs, N s/m
};

/// Computes the initial state. Throws std::runtime_error if the two spring constants differ.
BodyStart startOf(const BodySetup& setup);

using scenes::fromBullet;
using scenes::toBullet;

}  // namespace limber::bullet_soft
