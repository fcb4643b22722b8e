// SPDX-License-Identifier: Zlib
#pragma once

#include "bullet/soft_body_data.h"

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

/// A point can be pushed faster within the tick than it was at its start.
constexpr double kReachPerMotion = 1.5;

/// Where a point may get in a tick.
struct Reach {
  Eigen::Vector3d low, high;
  double distance;  ///< m, beyond the radius
};

inline Reach reachOf(const SoftBodyData& body, Eigen::Index i, double tick) {
  const double radius = double(body.masses.shape->getRadius());
  const Eigen::Vector3d x = body.state.position.col(i);
  const double motion =
      tick * body.state.velocity.col(i).norm() + tick * tick * body.state.acceleration.col(i).norm();
  const double distance = kReachPerMotion * motion + radius / 3.0;
  const double size = radius + distance;
  return {x.array() - size, x.array() + size, distance};
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
