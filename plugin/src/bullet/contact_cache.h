// SPDX-License-Identifier: Zlib
#pragma once

#include "bullet/rigid_shapes.h"
#include "bullet/soft_body_data.h"

#include <cstdint>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

// A point at rest on a flat face need not ask Bullet's narrowphase again in every tick.

/// Share of the radius that a point may have moved relative to the partner since its contact was found: on a
/// face nothing changes, round an edge or on a ball of 1 m the surface departs from the plane by (0.1 r)^2
/// / 2.
constexpr btScalar kStillThere = btScalar(0.1);

/// Tells a convex partner as it is now from any other, and from itself with another shape: objects and shapes
/// may be changed, or deleted and others made in their place, and some broadphases use their ids again. 0:
/// not convex.
inline std::uint64_t stampOf(const btCollisionObject& partner) {
  const btCollisionShape& shape = *partner.getCollisionShape();
  if (!shape.isConvex()) return 0;
  std::uint64_t hash = hashOfShape(shape);
  for (const std::uint64_t part :
       {std::uint64_t{reinterpret_cast<std::uintptr_t>(&partner)},
        std::uint64_t{reinterpret_cast<std::uintptr_t>(&shape)},
        static_cast<std::uint64_t>(partner.getBroadphaseHandle()->m_uniqueId)})
    addToHash(hash, part);
  return hash | 1;
}

/// Remembers a contact (world coordinates, the point's centre at `place`) with a convex partner; forgets what
/// was there before.
inline void keepContact(CachedContact& cached, std::uint64_t stamp, const btCollisionObject& partner,
                        const btVector3& surface, const btVector3& normal, const btVector3& place) {
  if (stamp == 0) return;
  const btTransform& pose = partner.getWorldTransform();
  cached.partner = stamp;
  cached.surface = pose.invXform(surface);
  cached.normal = normal * pose.getBasis();
  cached.place = pose.invXform(place);
}

/// Whether the remembered contact is one with this partner and still good.
inline bool isKept(const CachedContact& cached, std::uint64_t stamp, const btCollisionObject& partner,
                   const btVector3& place, btScalar radius) {
  if (stamp == 0 || cached.partner != stamp) return false;
  const btScalar way = kStillThere * radius;
  return (partner.getWorldTransform().invXform(place) - cached.place).length2() <= way * way;
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
