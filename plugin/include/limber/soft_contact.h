// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/bullet_precision.h>
#include <limber/soft_body.h>

#include <btBulletDynamicsCommon.h>

#include <array>
#include <cstdint>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

/// A point on a soft body: the sum of weights[i] times the position of points[i].
struct ContactSide {
  static constexpr std::uint32_t kNone = 0xffffffffu;

  std::uint32_t triangle = kNone;  ///< index into network().surface; if an edge or a point touches, the
                                   ///< adjacent triangle that faces the other side most. kNone: the body has
                                   ///< no triangles, or Collision::Points
  std::array<std::uint32_t, 3> points{};  ///< the corners of the triangle in order; without a triangle the
                                          ///< points in contact, the last one repeated
  Eigen::Vector3d weights = Eigen::Vector3d::Zero();  ///< 0 or more, sum 1; all 0: not on a soft body
};

/// A contact of a soft body in the last tick, with its impulse, seen from `body`. Two soft bodies in contact
/// have one contact each, with the sides exchanged. For a body that touches itself there is one contact, in
/// which `otherBody` is the same body.
struct SoftContact {
  SoftBody* body = nullptr;
  const btCollisionObject* other = nullptr;  ///< for a soft body its surface object, or its point mass
  SoftBody* otherBody = nullptr;             ///< nullptr: `other` is not soft
  ContactSide side, otherSide;               ///< otherSide is set only if `other` is soft
  btVector3 position = btVector3(0, 0, 0);   ///< m, on the surface of `body`, its radius included
  btVector3 normal = btVector3(0, 0, 0);     ///< unit, from other to body
  double distance = 0.0;  ///< m between the surfaces at the end of the tick, below 0 where they overlap; the
                          ///< other surface is at position - distance * normal
  btVector3 impulse = btVector3(0, 0, 0);          ///< N s on body, sum over the tick
  double normalImpulse = 0.0;                      ///< N s, the part of `impulse` along the normal, 0 or more
  btVector3 frictionImpulse = btVector3(0, 0, 0);  ///< N s, the part across the normal (on a curved
                                                   ///< surface, the normal at each moment)
};

/// Returns contact `point` of a manifold in Bullet's dispatcher. The manifold belongs to a point mass or to a
/// surface object (SoftBodySystem::reportManifolds()). `body` is the first of the two objects that is soft;
/// nullptr if neither is, or if the manifold has no such contact. A manifold stores only part of a
/// SoftContact: the position, for which the nearest point of the stored triangle is returned, and the
/// impulses along and across the normal.
SoftContact readContact(const btPersistentManifold& manifold, int point);

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
