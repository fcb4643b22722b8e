// SPDX-License-Identifier: Zlib
#pragma once

#include "bullet/convert.h"
#include "bullet/soft_body_data.h"

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

/// A point can be pushed faster within the tick than it was at its start.
constexpr double kReachPerMotion = 1.5;

/// Of two contacts of a point whose normals are closer than this (cosine), only the nearer counts:
/// neighbouring triangles of a flat surface are one surface.
constexpr double kSameSurface = 0.995;

/// m/s at which a point is lifted out of what it has got into: 25 radii per second, 0.5 m/s for the usual
/// 2 cm.
inline double recoverySpeed(double radius) { return 25.0 * radius; }

/// Where a point can get in a tick.
struct Reach {
  Eigen::Vector3d low, high;
  double distance;  ///< m, beyond the radius
};

/// `partnerMotion` (m) is what comes towards it.
inline Reach reachOf(const SoftBodyData& body, Eigen::Index i, double tick, double partnerMotion = 0.0) {
  const double radius = double(body.masses.shape->getRadius());
  const Eigen::Vector3d x = body.state.position.col(i);
  const double motion =
      tick * body.state.velocity.col(i).norm() + tick * tick * body.state.acceleration.col(i).norm();
  const double distance = kReachPerMotion * motion + partnerMotion + radius / 3.0;
  const double size = radius + distance;
  return {x.array() - size, x.array() + size, distance};
}

/// Whether the box of what is reached meets that of an object in the broadphase.
inline bool overlaps(const Reach& reach, const btCollisionObject& partner) {
  const btBroadphaseProxy& proxy = *partner.getBroadphaseHandle();
  return (toEigen(proxy.m_aabbMin).array() <= reach.high.array()).all() &&
         (toEigen(proxy.m_aabbMax).array() >= reach.low.array()).all();
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
