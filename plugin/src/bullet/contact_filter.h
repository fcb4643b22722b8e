// SPDX-License-Identifier: Zlib
#pragma once

#include "bullet/soft_body_data.h"

#include <algorithm>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

/// Whether contacts of `own`, the surface object or a point in the world, with another object count: both
/// answer them, and Bullet's broadphase pairs the two, by groups and masks or as the user's
/// btOverlapFilterCallback says.
inline bool arePaired(const SoftBodyData& body, const btCollisionObject& own,
                      const btCollisionObject& other) {
  auto* first = const_cast<btBroadphaseProxy*>(own.getBroadphaseHandle());
  auto* second = const_cast<btBroadphaseProxy*>(other.getBroadphaseHandle());
  return first && second && own.hasContactResponse() && other.hasContactResponse() &&
         body.world->getPairCache()->needsBroadphaseCollision(first, second);
}

/// Whether any of the body's points, or its surface, may collide with what has this proxy. The body's own
/// points and surface never do.
inline bool canHit(const SoftBodyData& body, const btBroadphaseProxy& proxy) {
  const auto& object = *static_cast<const btCollisionObject*>(proxy.m_clientObject);
  const PointMass* point = PointMass::from(&object);
  const SurfaceObject* surface = body.surface.object;
  if ((point && point->owner() == &body) || &object == surface || !object.hasContactResponse()) return false;
  if (surface)
    return (SurfaceObject::from(&object) || surface->mayTouch(object)) && arePaired(body, *surface, object);
  const auto& points = body.masses.bodies;
  return std::any_of(points.begin(), points.end(),
                     [&](const PointMass* p) { return p && arePaired(body, *p, object); });
}

/// Whether a point may collide with an object that canHit() of its body has let pass.
inline bool canHit(const SoftBodyData& body, const PointMass& point, const btCollisionObject& object) {
  return (body.surface.object || arePaired(body, point, object)) && point.checkCollideWith(&object) &&
         object.checkCollideWith(&point);
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
