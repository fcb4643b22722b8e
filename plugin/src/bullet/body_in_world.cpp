// SPDX-License-Identifier: Zlib
#include "bullet/body_in_world.h"

#include "bullet/contact_gather.h"
#include "bullet/point_masses.h"
#include "bullet/surface_body.h"

#include <algorithm>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

void addToWorld(SoftBodyData& body) {
  (isSurfaceBody(body) ? addSurface : addPointMasses)(body);
  addContactWatch(body);
}

void removeFromWorld(SoftBodyData& body) { (isSurfaceBody(body) ? removeSurface : removePointMasses)(body); }

bool anyInWorld(const SoftBodyData& body) {
  if (isSurfaceBody(body)) return body.surface.object && body.surface.object->isInWorld();
  const auto isIn = [](const PointMass* point) { return point && point->isInWorld(); };
  return std::any_of(body.masses.bodies.begin(), body.masses.bodies.end(), isIn);
}

bool wholeInWorld(const SoftBodyData& body) {
  if (isSurfaceBody(body)) return body.surface.object && body.surface.object->isInWorld();
  const auto isIn = [](const PointMass* point) { return point && point->isInWorld(); };
  return std::all_of(body.masses.bodies.begin(), body.masses.bodies.end(), isIn);
}

void wakeBody(SoftBodyData& body, bool insideTick) {
  if (isSurfaceBody(body))
    wakeSurface(body);
  else
    wakeWorldPoints(body, insideTick);
  body.asleep = false;
  body.calmTime = 0.0;
}

bool isRestless(const SoftBodyData& body, btScalar tick) {
  return (isSurfaceBody(body) ? anySurfacePointMoves : anyPointMoves)(body, tick);
}

void gatherBody(SoftBodyData& body, btScalar tick) {
  (isSurfaceBody(body) ? gatherSurface : gatherWorldPoints)(body, tick);
}

void handOverBody(SoftBodyData& body, btScalar tick) {
  (isSurfaceBody(body) ? handOverBox : handOverVelocities)(body, tick);
}

void finishBody(SoftBodyData& body, btScalar tick) {
  (isSurfaceBody(body) ? finishSurface : finishWorldPoints)(body, tick);
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
