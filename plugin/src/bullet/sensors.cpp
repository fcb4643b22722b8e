// SPDX-License-Identifier: Zlib

// This file finds the contacts of surfaces with sensors. They have no part in the step: the positions after
// the tick are tested against the objects with Bullet's narrowphase.

#include "bullet/sensors.h"

#include "bullet/contact_report.h"
#include "bullet/point_masses.h"
#include "bullet/soft_body_data.h"
#include "bullet/surface_body.h"

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {
namespace {

using Eigen::Vector3d;

/// Keeps the deepest contact with an object, seen from the other one.
struct DeepestContact final : btCollisionWorld::ContactResultCallback {
  explicit DeepestContact(const btCollisionObject& p) : partner(&p) { m_closestDistanceThreshold = 0; }
  const btCollisionObject* partner;
  bool any = false;
  btScalar distance = 0;
  btVector3 normal, position, partnerPosition;  // m, on the soft body; on the partner
  int triangle = -1, partnerTriangle = -1;      // likewise

  btScalar addSingleResult(btManifoldPoint& p, const btCollisionObjectWrapper* first, int, int index0,
                           const btCollisionObjectWrapper*, int, int index1) override {
    if (p.getDistance() > 0 || (any && p.getDistance() >= distance)) return 0;
    const bool isSecond = first->getCollisionObject() == partner;
    any = true;
    distance = p.getDistance();
    normal = isSecond ? -p.m_normalWorldOnB : p.m_normalWorldOnB;
    position = isSecond ? p.m_positionWorldOnB : p.m_positionWorldOnA;
    partnerPosition = isSecond ? p.m_positionWorldOnA : p.m_positionWorldOnB;
    triangle = isSecond ? index1 : index0;
    partnerTriangle = isSecond ? index0 : index1;
    return 0;
  }
};

SoftContact contactOf(const SoftBodyData& body, const DeepestContact& hit) {
  SoftContact c;
  c.body = body.handle;
  c.other = hit.partner;
  c.otherBody = readSide(hit.partner, hit.partnerTriangle, hit.partnerPosition, c.otherSide);
  c.position = hit.position;
  c.normal = hit.normal;
  c.distance = double(hit.distance);
  return c;
}

DeepestContact deepestOf(SoftBodyData& body, btCollisionObject& own, const btCollisionObject& partner) {
  DeepestContact hit(partner);
  body.world->contactPairTest(&own, const_cast<btCollisionObject*>(&partner), hit);
  return hit;
}

void addToReport(SoftBodyData& body, const SoftContact& contact, const ObjectHandle& partner) {
  body.report.contacts.push_back(contact);
  body.report.partners.push_back(partner);
}

/// Adds the points that touch the partner. Returns whether there are any.
bool addPoints(SoftBodyData& body, const ObjectHandle& partner) {
  btVector3 low, high;
  partner.object->getCollisionShape()->getAabb(partner.object->getWorldTransform(), low, high);
  const Vector3d from = toEigen(low).array() - radiusOf(body), to = toEigen(high).array() + radiusOf(body);
  bool any = false;
  for (std::uint32_t i = 0; i < pointCount(body); ++i) {
    const Vector3d x = body.state.position.col(i);
    if (!(x.array() >= from.array()).all() || !(x.array() <= to.array()).all()) continue;
    const DeepestContact hit = deepestOf(body, probeAt(body, i), *partner.object);
    if (!hit.any) continue;
    SoftContact c = contactOf(body, hit);
    c.side.points = {i, i, i};
    c.side.weights = Vector3d::UnitX();
    addToReport(body, c, partner);
    any = true;
  }
  return any;
}

/// Bullet has no algorithm for concave objects with each other, nor for planes with triangles.
void addSurfaceOf(SoftBodyData& body, const ObjectHandle& partner) {
  const btCollisionShape& shape = *partner.object->getCollisionShape();
  if (!shape.isConvex() && !shape.isCompound()) return;
  const DeepestContact hit = deepestOf(body, *body.surface.object, *partner.object);
  if (!hit.any) return;
  SoftContact c = contactOf(body, hit);
  readSide(body.surface.object, hit.triangle, hit.position, c.side);
  if (c.side.weights.isZero(0.0)) return;
  addToReport(body, c, partner);
}

}  // namespace

bool addSensor(SoftBodyData& body, btCollisionObject& partner) {
  const SurfaceObject* own = body.surface.object;
  if (!own || (own->hasContactResponse() && partner.hasContactResponse())) return false;
  if (own->mayTouch(partner) && !PointMass::from(&partner)) body.sensors.push_back(handleOf(partner));
  return true;
}

void reportSensors(SoftBodyData& body) {
  if (!body.surface.object || body.surface.object->getWorldArrayIndex() < 0) return;
  for (const ObjectHandle& partner : body.sensors)
    if (isValid(*body.world, partner) && !addPoints(body, partner)) addSurfaceOf(body, partner);
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
