// SPDX-License-Identifier: Zlib
#include "bullet/contact_gather.h"

#include "bullet/contact_cache.h"
#include "bullet/contact_filter.h"
#include "bullet/contact_reach.h"
#include "bullet/convert.h"
#include "bullet/point_masses.h"
#include "bullet/point_rows.h"
#include "bullet/surface_body.h"
#include "bullet/surface_partners.h"

#include <algorithm>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {
namespace {

/// Of the radius: a point that reaches no farther, the third of it that is always looked at included, is
/// slow.
constexpr double kSlowReach = 0.6;

void forgetPartners(SoftBodyData& body) {
  body.partners.clear();
  body.freePartners.clear();
  body.softPartners.clear();
}

bool hasPartners(const SoftBodyData& body) {
  return !body.partners.empty() || !body.freePartners.empty() || !body.softPartners.empty();
}

template <class T>
void addOnce(std::vector<T>& list, T entry) {
  if (std::find(list.begin(), list.end(), entry) == list.end()) list.push_back(entry);
}

/// Sorts them by what they are. Point masses in the world meet other bodies' points in Bullet's solver.
void addPartner(SoftBodyData& body, btCollisionObject& object) {
  if (PointMass::from(&object)) return;
  if (SurfaceObject* surface = SurfaceObject::from(&object)) {
    if (isSurfaceBody(body) && surface->owner()) addOnce(body.softPartners, surface->owner());
  } else if (object.isStaticOrKinematicObject()) {
    addOnce<const btCollisionObject*>(body.partners, &object);
  } else if (btRigidBody* rigid = btRigidBody::upcast(&object)) {
    addOnce(body.freePartners, rigid);
  }
}

/// Collects the partners of a body in a tick.
struct PartnersInBox final : btBroadphaseAabbCallback {
  explicit PartnersInBox(SoftBodyData& b) : body(&b) {}
  SoftBodyData* body;

  bool process(const btBroadphaseProxy* proxy) override {
    if (canHit(*body, *proxy)) addPartner(*body, *static_cast<btCollisionObject*>(proxy->m_clientObject));
    return true;
  }
};

void addPlaneRow(RowsOfPair& rows, const SoftBodyData& body, std::uint32_t i,
                 const btCollisionObject& partner, double reach) {
  const auto& plane = *static_cast<const btStaticPlaneShape*>(partner.getCollisionShape());
  const btTransform& pose = partner.getWorldTransform();
  const Eigen::Vector3d normal = toEigen(pose.getBasis() * plane.getPlaneNormal());
  const btVector3 onPlane = pose * (plane.getPlaneNormal() * plane.getPlaneConstant());
  const Eigen::Vector3d x = body.state.position.col(i);
  const double height = normal.dot(x - toEigen(onPlane));
  if (height - double(body.masses.shape->getRadius()) > reach) return;
  rows.add(normal, toBullet(Eigen::Vector3d(x - height * normal)));
}

/// Uses the contact that Bullet found a tick ago. On a flat face it is as good as new; a slow point has not
/// left that face. False if there is none or the point is too fast for it.
bool addCachedRow(RowsOfPair& rows, const SoftBodyData& body, std::uint32_t i,
                  const btCollisionObject& partner, double reach) {
  const PointMass& point = *body.masses.bodies[i];
  const btPersistentManifold* manifold = point.cachedContact;
  const double radius = double(body.masses.shape->getRadius());
  if (!manifold || reach > kSlowReach * radius) return false;
  const bool pointIsFirst = manifold->getBody0() == &point;
  if ((pointIsFirst ? manifold->getBody1() : manifold->getBody0()) != &partner) return false;
  const btManifoldPoint& contact = manifold->getContactPoint(0);
  const btVector3 normal = pointIsFirst ? contact.m_normalWorldOnB : -contact.m_normalWorldOnB;
  rows.add(toEigen(normal),
           partner.getWorldTransform() * (pointIsFirst ? contact.m_localPointB : contact.m_localPointA));
  return true;
}

/// The same for a point outside the world, for which Bullet keeps none.
bool addKeptRow(RowsOfPair& rows, const SoftBodyData& body, std::uint32_t i, const btCollisionObject& partner,
                double reach) {
  const CachedContact& cached = body.surface.contacts[i];
  const double radius = double(body.masses.shape->getRadius());
  const btVector3 place = toBullet(Eigen::Vector3d(body.state.position.col(i)));
  if (reach > kSlowReach * radius || !isKept(cached, partner, place, body.masses.shape->getRadius()))
    return false;
  const btTransform& pose = partner.getWorldTransform();
  rows.add(toEigen(pose.getBasis() * cached.normal), pose * cached.surface);
  return true;
}

/// Asks Bullet's narrowphase.
void addFoundRows(RowsOfPair& rows, SoftBodyData& body, std::uint32_t i, const btCollisionObject& partner) {
  if (!body.masses.shared) writePoint(body, i);
  body.world->contactPairTest(body.masses.bodies[i], const_cast<btCollisionObject*>(&partner), rows);
  if (isSurfaceBody(body)) rows.keepContact(body.surface.contacts[i]);
}

/// Nobody can have excluded a pair with a point that nobody outside knows.
bool mayBeExcluded(const SoftBodyData& body) { return body.masses.shared || !body.anchors.empty(); }

bool isExcluded(const PointMass& point, const btCollisionObject& partner) {
  return !point.checkCollideWith(&partner) || !partner.checkCollideWith(&point);
}

void addRows(SoftBodyData& body, std::uint32_t i, const btCollisionObject& partner, btScalar tick) {
  const Reach reach = reachOf(body, i, double(tick));
  if (!overlaps(reach, partner)) return;
  if (mayBeExcluded(body) && isExcluded(*body.masses.bodies[i], partner)) return;
  // what a moving partner travels is reached, too
  const btRigidBody* rigid = btRigidBody::upcast(&partner);
  const double travel =
      rigid && rigid->isKinematicObject() ? double(rigid->getLinearVelocity().length() * tick) : 0.0;
  const double distance = reach.distance + kReachPerMotion * travel;
  RowsOfPair rows(body, i, partner, distance, tick);
  const int shape = partner.getCollisionShape()->getShapeType();
  if (shape == STATIC_PLANE_PROXYTYPE)
    addPlaneRow(rows, body, i, partner, distance);
  else if (shape == BOX_SHAPE_PROXYTYPE && isSurfaceBody(body))
    rows.addOnBox(*static_cast<const btBoxShape*>(partner.getCollisionShape()), partner.getWorldTransform());
  else if (!(isSurfaceBody(body) ? addKeptRow : addCachedRow)(rows, body, i, partner, distance))
    addFoundRows(rows, body, i, partner);
}

/// Calls visit(manifold point, soft body, point, partner) for all contacts of point masses.
template <class Visit>
void forEachContact(btDispatcher& dispatcher, Visit visit) {
  for (int m = 0; m < dispatcher.getNumManifolds(); ++m) {
    btPersistentManifold& manifold = *dispatcher.getManifoldByIndexInternal(m);
    PointMass* first = PointMass::from(const_cast<btCollisionObject*>(manifold.getBody0()));
    PointMass* point = first ? first : PointMass::from(const_cast<btCollisionObject*>(manifold.getBody1()));
    if (!point || !point->owner()) continue;
    const btCollisionObject* partner = first ? manifold.getBody1() : manifold.getBody0();
    visit(manifold, *point, partner);
  }
}

}  // namespace

namespace {

/// The box around all reaches; keeps how far contacts are looked for.
Eigen::AlignedBox3d reachBox(SoftBodyData& body, double tick) {
  Eigen::AlignedBox3d box;
  body.reach.resize(body.masses.bodies.size());
  for (Eigen::Index i = 0; i < body.state.position.cols(); ++i) {
    const Reach reach = reachOf(body, i, tick);
    body.reach[static_cast<std::size_t>(i)] = reach.distance;
    box.extend(reach.low).extend(reach.high);
  }
  return box;
}

/// Takes over what Bullet's broadphase has found around a surface body.
void takePartners(SoftBodyData& body) {
  for (btCollisionObject* partner : body.surface.partners)
    if (partner->hasContactResponse() &&
        (SurfaceObject::from(partner) || body.surface.object->mayTouch(*partner)))
      addPartner(body, *partner);
  body.surface.partners.clear();
}

/// Whether Bullet's broadphase knows that nothing is in the way of a body that flies as was foreseen: then
/// nothing pushes its points aside either.
bool fliesFreely(SoftBodyData& body, double tick) {
  if (hasPartners(body)) return false;
  const bool foreseen = !body.masses.shared && body.surface.flight.tick == tick;
  const Flight flight = foreseen ? body.surface.flight : flightOf(body, tick);
  if (!foreseen && !partnersCover(body, flight.box)) return false;
  body.reach.assign(body.masses.bodies.size(), flight.reach);
  return true;
}

void askForPartners(SoftBodyData& body, const Eigen::AlignedBox3d& box) {
  PartnersInBox partners(body);
  body.world->getBroadphase()->aabbTest(toBullet(Eigen::Vector3d(box.min())),
                                        toBullet(Eigen::Vector3d(box.max())), partners);
}

}  // namespace

void gatherContacts(SoftBodyData& body, btScalar tick) {
  body.contacts.clear();
  body.contactPartners.clear();
  forgetPartners(body);
  const bool surface = isSurfaceBody(body);
  if (surface) takePartners(body);
  if (surface && fliesFreely(body, double(tick))) return;
  const Eigen::AlignedBox3d box = reachBox(body, double(tick));
  if (!surface || !partnersCover(body, box)) askForPartners(body, box);
  body.partnerMarks.clear();
  if (surface && body.partners.empty()) return;
  for (const btCollisionObject* partner : body.partners) body.partnerMarks.push_back(markOf(*partner));
  for (std::uint32_t i = 0; i < body.masses.bodies.size(); ++i) {
    for (const btCollisionObject* partner : body.partners)
      if (!body.masses.held[i]) addRows(body, i, *partner, tick);
    // Bullet may free a manifold at any time after this
    if (!surface) body.masses.bodies[i]->cachedContact = nullptr;
  }
}

void readManifolds(btDispatcher& dispatcher) {
  forEachContact(
      dispatcher, [](btPersistentManifold& manifold, PointMass& point, const btCollisionObject* partner) {
        if (point.owner()->asleep || !partner->isStaticOrKinematicObject()) return;
        const bool simple = manifold.getNumContacts() == 1 && !partner->getCollisionShape()->isConcave() &&
                            !partner->getCollisionShape()->isCompound();
        if (simple) point.cachedContact = &manifold;
        for (int p = 0; p < manifold.getNumContacts(); ++p) {
          btManifoldPoint& contact = manifold.getContactPoint(p);
          contact.m_appliedImpulse = contact.m_appliedImpulseLateral1 = contact.m_appliedImpulseLateral2 = 0;
        }
      });
}

void reportContactImpulses(btDispatcher& dispatcher) {
  forEachContact(dispatcher, [](btPersistentManifold& manifold, PointMass& point,
                                const btCollisionObject* partner) {
    const SoftBodyData& body = *point.owner();
    const RowRange rows = rowsOfPoint(body.contacts, point.index());
    for (std::size_t r = rows.begin; r < rows.end; ++r) {
      const ContactRow& row = body.contacts[r];
      if (body.contactPartners[r] != partner) continue;
      int nearest = -1;
      for (int p = 0; p < manifold.getNumContacts(); ++p) {
        const double along = std::abs(toEigen(manifold.getContactPoint(p).m_normalWorldOnB).dot(row.normal));
        if (along > kSameSurface && nearest < 0) nearest = p;
      }
      if (nearest < 0) continue;
      manifold.getContactPoint(nearest).m_appliedImpulse +=
          static_cast<btScalar>(row.normal.dot(row.impulse));
    }
  });
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
