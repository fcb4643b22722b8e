// SPDX-License-Identifier: Zlib
#pragma once

#include "engines/engine.h"

#include <Eigen/Geometry>

namespace limber::bench {

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

inline btVector3 toBullet(const Eigen::Vector3d& v) {
  return btVector3(static_cast<btScalar>(v.x()), static_cast<btScalar>(v.y()), static_cast<btScalar>(v.z()));
}

inline Eigen::Vector3d fromBullet(const btVector3& v) {
  return {static_cast<double>(v.x()), static_cast<double>(v.y()), static_cast<double>(v.z())};
}

}  // namespace limber::bench
