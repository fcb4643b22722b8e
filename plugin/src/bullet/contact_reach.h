// SPDX-License-Identifier: Zlib
#pragma once

#include "bullet/bullet_objects.h"
#include "bullet/soft_body_data.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

/// A point can be pushed faster within the tick than it was at its start.
constexpr double kReachPerMotion = 1.5;

/// Of two contacts of a point whose normals are closer than this (cosine), only the nearer counts:
/// neighbouring triangles of a flat surface are one surface.
constexpr double kSameSurface = 0.995;

/// m/s at which things that have got `size` (m) large into each other are drawn apart at most: they must not
/// fly. A fall through 0.65 of the size is as fast, 0.5 m/s for points of 2 cm. Without gravity it is a tenth
/// of the size in a tick.
inline double recoverySpeed(double size, double gravity, double tick) {
  return std::max(std::sqrt(1.3 * gravity * size), 0.1 * size / tick);
}

inline ContactSpeeds contactSpeeds(const SoftBodyData& body, double tick) {
  const double gravity = toEigen(body.world->getGravity()).norm();
  // what gravity gives in a tenth of a tick is no bounce
  return {recoverySpeed(double(body.masses.shape->getRadius()), gravity, tick), 0.1 * gravity * tick};
}

/// Where a point may get in a tick.
struct Reach {
  Eigen::Vector3d low, high;
  double distance;  ///< m, beyond the radius
};

/// Of a point with a velocity in `time` s; `partnerMotion` (m) is what comes towards it.
inline Reach reachFrom(const SoftBodyData& body, Eigen::Index i, const Eigen::Vector3d& velocity, double time,
                       double partnerMotion = 0.0) {
  const double radius = double(body.masses.shape->getRadius());
  const Eigen::Vector3d x = body.state.position.col(i);
  const double motion = time * velocity.norm() + time * time * body.state.acceleration.col(i).norm();
  const double distance = kReachPerMotion * motion + partnerMotion + radius / 3.0;
  const double size = radius + distance;
  return {x.array() - size, x.array() + size, distance};
}

inline Reach reachOf(const SoftBodyData& body, Eigen::Index i, double tick, double partnerMotion = 0.0) {
  return reachFrom(body, i, body.state.velocity.col(i), tick, partnerMotion);
}

/// Whether the box of what is reached meets that of an object in the broadphase.
inline bool overlaps(const Reach& reach, const btCollisionObject& partner) {
  const btBroadphaseProxy& proxy = *partner.getBroadphaseHandle();
  return (toEigen(proxy.m_aabbMin).array() <= reach.high.array()).all() &&
         (toEigen(proxy.m_aabbMax).array() >= reach.low.array()).all();
}

/// The mean of a quantity per point, by mass.
inline Eigen::Vector3d meanOf(const SpringNetwork& network, const Points& quantity) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (Eigen::Index i = 0; i < quantity.cols(); ++i)
    mean += network.massShares[static_cast<std::size_t>(i)] * quantity.col(i);
  return mean;
}

/// Where the points of a body may get in a tick if nothing is in their way: the body flies on, and its points
/// move relative to that as each may (reachOf). Smaller than the box around all reaches, which also hold what
/// a hit may push aside.
inline Flight flightOf(const SoftBodyData& body, double tick) {
  const PointState& s = body.state;
  const Eigen::Vector3d mean = meanOf(*body.network, s.velocity);
  Eigen::AlignedBox3d box;
  double fastest = 0.0;
  for (Eigen::Index i = 0; i < s.position.cols(); ++i) {
    box.extend(s.position.col(i));
    fastest = std::max(fastest, (s.velocity.col(i) - mean).squaredNorm());
  }
  const double radius = double(body.masses.shape->getRadius());
  const double fall = tick * tick * s.acceleration.col(0).norm();
  const double margin = radius + radius / 3.0 + kReachPerMotion * (tick * std::sqrt(fastest) + fall);
  const Eigen::Vector3d way = kReachPerMotion * tick * mean;
  const Eigen::Vector3d low = box.min() + way.cwiseMin(0.0), high = box.max() + way.cwiseMax(0.0);
  return {{low.array() - margin, high.array() + margin}, margin - radius + way.norm(), tick};
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
