// SPDX-License-Identifier: Zlib
#pragma once

#include "bullet/surface_data.h"

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

// A point at rest on a flat face need not ask Bullet's narrowphase again in every tick.

/// Share of the radius that a point may have moved relative to the partner since its contact was found: on a
/// face nothing changes, round an edge or on a ball of 1 m the surface departs from the plane by (0.1 r)^2
/// / 2.
constexpr btScalar kStillThere = btScalar(0.1);

/// Remembers a contact (world coordinates, the point's centre at `place`) with a convex partner; forgets what
/// was there before.
inline void keepContact(CachedContact& cached, const btCollisionObject& partner, const btVector3& surface,
                        const btVector3& normal, const btVector3& place) {
  const btCollisionShape& shape = *partner.getCollisionShape();
  if (shape.isConcave() || shape.isCompound()) return;
  const btTransform& pose = partner.getWorldTransform();
  cached.partner = partner.getBroadphaseHandle()->m_uniqueId;
  cached.surface = pose.invXform(surface);
  cached.normal = normal * pose.getBasis();
  cached.place = pose.invXform(place);
}

/// Whether the remembered contact is one with this partner and still good.
inline bool isKept(const CachedContact& cached, const btCollisionObject& partner, const btVector3& place,
                   btScalar radius) {
  if (cached.partner != partner.getBroadphaseHandle()->m_uniqueId) return false;
  const btScalar way = kStillThere * radius;
  return (partner.getWorldTransform().invXform(place) - cached.place).length2() <= way * way;
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
