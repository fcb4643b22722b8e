// SPDX-License-Identifier: Zlib
#include "bullet/surface_partners.h"

#include "bullet/bullet_objects.h"
#include "bullet/kinematic_motion.h"

#include <algorithm>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {
namespace {

bool olderProxy(const btCollisionObject* a, const btCollisionObject* b) {
  return a->getBroadphaseHandle()->m_uniqueId < b->getBroadphaseHandle()->m_uniqueId;
}

/// Keeps the order of the ids, not that of Bullet's hash table.
void addPartner(SoftBodyData& body, btCollisionObject* partner) {
  auto& partners = body.surface.partners;
  const auto place = std::lower_bound(partners.begin(), partners.end(), partner, olderProxy);
  if (place == partners.end() || *place != partner) partners.insert(place, partner);
}

}  // namespace

bool mayWake(const btRigidBody& own, const btCollisionObject& partner) {
  const SurfaceObject* surface = SurfaceObject::from(&own);
  const bool excluded = surface ? !surface->mayTouch(partner)
                                : !own.checkCollideWith(&partner) || !partner.checkCollideWith(&own);
  return !excluded && own.hasContactResponse() && partner.hasContactResponse();
}

void meetPartner(SoftBodyData& body, btRigidBody& own, btCollisionObject& partner) {
  if (!body.asleep || own.isActive())
    addPartner(body, &partner);
  else if (isKinematic(partner) && partner.isActive() && mayWake(own, partner))
    own.activate(true);
}

SurfaceObject* livingSurface(const btBroadphaseProxy* proxy, const void* system) {
  SurfaceObject* surface = SurfaceObject::from(static_cast<btCollisionObject*>(proxy->m_clientObject));
  const SoftBodyData* body = surface ? surface->owner() : nullptr;
  return body && body->system == system && body->alive ? surface : nullptr;
}

void collectPartners(btDiscreteDynamicsWorld& world, const void* system) {
  const btBroadphasePairArray& pairs = world.getPairCache()->getOverlappingPairArray();
  for (int i = 0; i < pairs.size(); ++i) {
    const btBroadphaseProxy *a = pairs[i].m_pProxy0, *b = pairs[i].m_pProxy1;
    for (int side = 0; side < 2; ++side, std::swap(a, b)) {
      auto* partner = static_cast<btCollisionObject*>(b->m_clientObject);
      if (SurfaceObject* surface = livingSurface(a, system)) meetPartner(*surface->owner(), *surface, *partner);
    }
  }
}

bool partnersCover(const SoftBodyData& body, const Eigen::AlignedBox3d& box) {
  const SurfaceShape& shape = *body.surface.shape;
  // the box went through rounding, the broadphase adds gContactBreakingThreshold on all sides
  const double slack = 0.5 * double(gContactBreakingThreshold);
  return body.surface.flight.tick > 0.0 &&
         (box.min().array() >= toEigen(shape.low()).array() - slack).all() &&
         (box.max().array() <= toEigen(shape.high()).array() + slack).all();
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
