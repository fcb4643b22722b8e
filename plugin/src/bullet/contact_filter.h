// SPDX-License-Identifier: Zlib
#pragma once

#include "bullet/soft_body_data.h"

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

/// Whether the user's groups and masks let the points of a body collide with what has this proxy, and that
/// answers contacts at all. The body's own points never do.
inline bool canHit(const SoftBodyData& body, const btBroadphaseProxy& proxy) {
  const auto* object = static_cast<const btCollisionObject*>(proxy.m_clientObject);
  const PointMass* point = PointMass::from(object);
  if (point && point->owner() == &body) return false;
  return (proxy.m_collisionFilterGroup & body.settings.collisionMask) &&
         (proxy.m_collisionFilterMask & body.settings.collisionGroup) && object->hasContactResponse();
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
