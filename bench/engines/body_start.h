// SPDX-License-Identifier: Zlib
#pragma once

#include "engines/engine.h"

#include <Eigen/Geometry>

namespace limber::bench {

/// The state a body starts in and the constants of its springs: what Limber makes of a set-up, for others.
struct BodyStart {
  Eigen::Matrix3Xd positions, velocities;  ///< 3 x #points
  Eigen::VectorXd masses;                  ///< #points, kg; pinned points have one, too
  Eigen::VectorXd restLengths;             ///< #springs, m
  Eigen::VectorXd stiffnesses;             ///< #springs, N/m
  Eigen::VectorXd dampings;                ///< #springs, N s/m
};

/// For springs that push as they pull: throws std::runtime_error where the two spring constants differ.
BodyStart startOf(const BodySetup& setup);

inline btVector3 toBullet(const Eigen::Vector3d& v) {
  return btVector3(static_cast<btScalar>(v.x()), static_cast<btScalar>(v.y()), static_cast<btScalar>(v.z()));
}

inline Eigen::Vector3d fromBullet(const btVector3& v) {
  return {static_cast<double>(v.x()), static_cast<double>(v.y()), static_cast<double>(v.z())};
}

}  // namespace limber::bench
