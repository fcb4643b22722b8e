// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/bullet_precision.h>
#include <limber/soft_body.h>

#include <btBulletDynamicsCommon.h>

#include <array>
#include <cstdint>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

/// A place on a soft body: the sum of weights[i] times the position of points[i].
struct ContactSide {
  static constexpr std::uint32_t kNone = 0xffffffffu;

  std::uint32_t triangle = kNone;  ///< index into network().surface; of an edge or a point that touches,
                                   ///< the triangle there that faces the other side most. kNone: of a
                                   ///< body without triangles, or with Collision::Points
  std::array<std::uint32_t, 3> points{};  ///< the triangle's corners in order; without a triangle those that
                                          ///< bear, the last repeated
  Eigen::Vector3d weights = Eigen::Vector3d::Zero();  ///< 0 or more, sum 1; all 0: no soft body here
};

/// Where a soft body touched something in the last tick, and what was borne there. Seen from `body`: of two
/// soft bodies that touch, each has its own, with the sides exchanged. A body that touches itself has one, of
/// which it is `otherBody`, too.
struct SoftContact {
  SoftBody* body = nullptr;
  const btCollisionObject* other = nullptr;  ///< of a soft one its surface object, or its point mass
  SoftBody* otherBody = nullptr;             ///< nullptr: the other is not soft
  ContactSide side, otherSide;               ///< otherSide of a soft one only
  btVector3 position = btVector3(0, 0, 0);   ///< m, on the surface of `body`, its radius included
  btVector3 normal = btVector3(0, 0, 0);     ///< unit, from other to body
  double distance = 0.0;  ///< m between the surfaces at the end of the tick, below 0 where they overlap; the
                          ///< other surface is at position - distance * normal
  btVector3 impulse = btVector3(0, 0, 0);  ///< N s on body, sum over the tick
  double normalImpulse = 0.0;              ///< N s, what of it pressed along the normal, 0 or more
  btVector3 frictionImpulse =
      btVector3(0, 0, 0);  ///< N s, what of it was across the normal
                           ///< (where the surface is curved, the normal of each moment)
};

/// The contact that a manifold in Bullet's dispatcher tells of: of a point mass with anything, or of a
/// surface object (SoftBodySystem::reportManifolds()). `body` is the first of the two that is soft; nullptr
/// if neither is, or there is no such point in the manifold. A manifold has a place, of which the nearest one
/// on the named triangle is given, and of impulses along the normal and across it.
SoftContact readContact(const btPersistentManifold& manifold, int point);

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
