// SPDX-License-Identifier: Zlib
#include "bullet/bullet_objects.h"
#include "bullet/point_masses.h"
#include "bullet/surface_body.h"

#include <limber/soft_contact.h>
#include <limber/surface_hit.h>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {
namespace {

/// The soft body an object is or is a part of, and where on it a contact is.
SoftBody* readSide(const btCollisionObject* object, int index, const btVector3& place, ContactSide& side) {
  if (const PointReference point = findPoint(object); point.body) {
    side.points = {point.index, point.index, point.index};
    side.weights = Eigen::Vector3d::UnitX();
    return point.body;
  }
  const SurfaceHit hit = surfaceHit(object, index, place);
  if (hit.body) {
    side.points = hit.points;
    side.weights = hit.weights;
    if (hit.triangle < hit.body->network().surface.size()) side.triangle = hit.triangle;
  }
  return findSurface(object).body;
}

/// The manifold's contact as its second object sees it.
void turnRound(SoftContact& c) {
  std::swap(c.side, c.otherSide);
  c.normal = -c.normal;
  c.impulse = -c.impulse;
  c.frictionImpulse = -c.frictionImpulse;
}

}  // namespace

SoftContact readContact(const btPersistentManifold& manifold, int point) {
  SoftContact c;
  if (point < 0 || point >= manifold.getNumContacts()) return c;
  const btManifoldPoint& p = manifold.getContactPoint(point);
  SoftBody* a = readSide(manifold.getBody0(), p.m_index0, p.m_positionWorldOnA, c.side);
  SoftBody* b = readSide(manifold.getBody1(), p.m_index1, p.m_positionWorldOnB, c.otherSide);
  if (!a && !b) return SoftContact();
  c.body = a ? a : b;
  c.otherBody = a ? b : nullptr;
  c.other = a ? manifold.getBody1() : manifold.getBody0();
  c.position = a ? p.m_positionWorldOnA : p.m_positionWorldOnB;
  c.normal = p.m_normalWorldOnB;
  c.distance = double(p.getDistance());
  c.normalImpulse = double(p.m_appliedImpulse);
  c.frictionImpulse = p.m_appliedImpulseLateral1 * p.m_lateralFrictionDir1 +
                      p.m_appliedImpulseLateral2 * p.m_lateralFrictionDir2;
  c.impulse = p.m_appliedImpulse * p.m_normalWorldOnB + c.frictionImpulse;
  if (!a) turnRound(c);
  return c;
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
