// SPDX-License-Identifier: Zlib
#pragma once

#include "core/links.h"

#include <array>
#include <cstdint>

namespace limber {

/// A place on the surface of a body: on a soft one a point mass or a place between two or three, on a rigid
/// one a place off its centre of mass, or one that nothing moves but as told.
struct ContactPlace {
  enum class Kind : std::uint8_t { Soft, Rigid, World } kind = Kind::World;
  std::uint32_t body = 0;                              ///< index into the group's points or rigids
  std::uint32_t count = 1;                             ///< of a Soft: how many points, 1 to 3
  std::array<std::uint32_t, 3> point{};                ///< of a Soft
  std::array<double, 3> weight{1.0};                   ///< of a Soft, sum 1
  Eigen::Vector3d arm = Eigen::Vector3d::Zero();       ///< of a Rigid: m, from its centre, world axes
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();  ///< of the World: m/s, constant over the tick
};

inline Eigen::Vector3d velocityAt(const LinkedBodies& bodies, const ContactPlace& place) {
  if (place.kind == ContactPlace::Kind::Rigid) return bodies.rigids[place.body].velocityAt(place.arm);
  if (place.kind == ContactPlace::Kind::World) return place.velocity;
  const Points& velocity = bodies.points[place.body]->velocity;
  Eigen::Vector3d sum = place.weight[0] * velocity.col(place.point[0]);
  for (std::uint32_t i = 1; i < place.count; ++i) sum += place.weight[i] * velocity.col(place.point[i]);
  return sum;
}

/// Adds an impulse (N s) there: to each point its share, so that momentum is kept and angular momentum, too.
inline void push(LinkedBodies& bodies, const ContactPlace& place, const Eigen::Vector3d& impulse) {
  if (place.kind == ContactPlace::Kind::Rigid)
    return bodies.rigids[place.body].applyImpulse(impulse, place.arm);
  if (place.kind == ContactPlace::Kind::World) return;
  PointState& p = *bodies.points[place.body];
  for (std::uint32_t i = 0; i < place.count; ++i)
    p.velocity.col(place.point[i]) +=
        place.weight[i] * impulse.cwiseProduct(p.inverseMass.col(place.point[i]));
}

/// 1/kg, 3 x 3: the velocity change there per impulse there.
Eigen::Matrix3d mobility(const LinkedBodies& bodies, const ContactPlace& place);

}  // namespace limber
