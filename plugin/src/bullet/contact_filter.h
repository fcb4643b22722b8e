// SPDX-License-Identifier: Zlib
#pragma once

#include "bullet/soft_body_data.h"

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

/// Whether the user's groups and masks let the points of a body collide with what has this proxy, and that
/// answers contacts at all. The body's own points and surface never do.
inline bool canHit(const SoftBodyData& body, const btBroadphaseProxy& proxy) {
  const auto* object = static_cast<const btCollisionObject*>(proxy.m_clientObject);
  const PointMass* point = PointMass::from(object);
  const SurfaceObject* surface = body.surface.object;
  if ((point && point->owner() == &body) || object == surface || !object->hasContactResponse()) return false;
  if (surface && !SurfaceObject::from(object) && !surface->mayTouch(*object)) return false;
  const btBroadphaseProxy* own = surface ? surface->getBroadphaseHandle() : nullptr;
  const int group = own ? own->m_collisionFilterGroup : body.settings.collisionGroup;
  const int mask = own ? own->m_collisionFilterMask : body.settings.collisionMask;
  return (proxy.m_collisionFilterGroup & mask) && (proxy.m_collisionFilterMask & group);
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
