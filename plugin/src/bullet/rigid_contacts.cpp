// SPDX-License-Identifier: Zlib

// This file finds what rigid bodies that soft ones push touch in their turn. It reads Bullet's manifolds,
// adds points that Bullet has given up, and reports what the contacts bore.

#include "bullet/bullet_objects.h"
#include "bullet/point_contacts.h"
#include "bullet/point_masses.h"
#include "bullet/soft_body_data.h"
#include "bullet/surface_body.h"
#include "bullet/tick_contacts.h"

#include <algorithm>
#include <functional>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

// --- points of manifolds -----------------------------------------------------------------------------------

namespace {

/// As many as two faces of boxes have.
constexpr std::size_t kMaxPoints = 8;

bool isBefore(const StoredManifoldPoint& x, const StoredManifoldPoint& y) {
  if (x.manifold != y.manifold) return std::less<const void*>()(x.manifold, y.manifold);
  return x.order < y.order;
}

bool has(const btPersistentManifold& manifold, const btManifoldPoint& point) {
  const btScalar same = manifold.getContactBreakingThreshold();
  for (int p = 0; p < manifold.getNumContacts(); ++p)
    if (manifold.getContactPoint(p).m_localPointA.distance2(point.m_localPointA) < same * same) return true;
  return false;
}

/// As btPersistentManifold::refreshContactPoints has it.
bool holds(const btPersistentManifold& manifold, const btManifoldPoint& point) {
  const btScalar most = manifold.getContactBreakingThreshold();
  const btVector3 apart = manifold.getBody0()->getWorldTransform() * point.m_localPointA -
                          manifold.getBody1()->getWorldTransform() * point.m_localPointB;
  const btScalar gap = apart.dot(point.m_normalWorldOnB);
  return gap <= most && (apart - gap * point.m_normalWorldOnB).length2() <= most * most;
}

void keep(const btPersistentManifold& manifold, const btManifoldPoint& point,
          std::vector<StoredManifoldPoint>& now) {
  now.push_back(
      {&manifold, manifold.getBody0(), manifold.getBody1(), static_cast<std::uint32_t>(now.size()), point});
}

/// Keeps the points of `manifold`, then those of it in kept.last that it has no more and that still hold.
/// Returns where the latter begin in kept.now; they go to its end.
std::size_t keepPoints(const btPersistentManifold& manifold, ManifoldPointHistory& kept) {
  const std::size_t first = kept.now.size();
  for (int p = 0; p < manifold.getNumContacts(); ++p) keep(manifold, manifold.getContactPoint(p), kept.now);
  const std::size_t extra = kept.now.size();
  const auto isEarlier = [](const StoredManifoldPoint& k, const btPersistentManifold* m) {
    return std::less<const void*>()(k.manifold, m);
  };
  auto k = std::lower_bound(kept.last.begin(), kept.last.end(), &manifold, isEarlier);
  for (; k != kept.last.end() && k->manifold == &manifold; ++k) {
    if (k->a != manifold.getBody0() || k->b != manifold.getBody1()) continue;
    if (has(manifold, k->point) || !holds(manifold, k->point)) continue;
    if (kept.now.size() - first < kMaxPoints) keep(manifold, k->point, kept.now);
  }
  return extra;
}

/// Ends a tick: what was kept becomes what is known.
void turnOver(ManifoldPointHistory& kept) {
  kept.last.swap(kept.now);
  kept.now.clear();
  std::sort(kept.last.begin(), kept.last.end(), isBefore);
}

}  // namespace

// --- contacts ----------------------------------------------------------------------------------------------

namespace {

constexpr btScalar kLeftAlone = -BT_LARGE_FLOAT;

/// Calls visit(place in the world's list, manifold) for both objects of all manifolds that matter.
template <class Visit>
void forEachSide(btDispatcher& dispatcher, Visit visit) {
  for (int m = 0; m < dispatcher.getNumManifolds(); ++m) {
    btPersistentManifold* manifold = dispatcher.getManifoldByIndexInternal(m);
    const btCollisionObject *a = manifold->getBody0(), *b = manifold->getBody1();
    if (manifold->getNumContacts() == 0 || isSoft(a) || isSoft(b)) continue;
    if (!a->hasContactResponse() || !b->hasContactResponse()) continue;
    for (const btCollisionObject* object : {a, b})
      if (object->getWorldArrayIndex() >= 0)
        visit(static_cast<std::size_t>(object->getWorldArrayIndex()), manifold);
  }
}

void fill(RigidManifolds& index, btDiscreteDynamicsWorld& world) {
  const auto objects = static_cast<std::size_t>(world.getNumCollisionObjects());
  index.begin.assign(objects + 2, 0);
  forEachSide(*world.getDispatcher(),
              [&](std::size_t object, btPersistentManifold*) { ++index.begin[object + 2]; });
  for (std::size_t i = 2; i < index.begin.size(); ++i) index.begin[i] += index.begin[i - 1];
  index.manifolds.resize(static_cast<std::size_t>(index.begin.back()));
  forEachSide(*world.getDispatcher(), [&](std::size_t object, btPersistentManifold* manifold) {
    index.manifolds[static_cast<std::size_t>(index.begin[object + 1]++)] = manifold;
  });
}

/// What the last tick bore, spread over its solves: two in each substep. Their number is not known yet.
ContactImpulse guess(const btManifoldPoint& point) {
  btVector3 t, u;
  btPlaneSpace1(point.m_normalWorldOnB, t, u);
  return {double(point.m_appliedImpulse),
          toEigen(t * point.m_appliedImpulseLateral1 + u * point.m_appliedImpulseLateral2)};
}

/// `reported`: what the contact bears is added to; may be null.
void addContact(TickContacts& found, const btPersistentManifold& manifold, const btManifoldPoint& point,
                const ContactImpulse& guess, btManifoldPoint* reported) {
  const btCollisionObject &a = *manifold.getBody0(), &b = *manifold.getBody1();
  const btVector3 onA = a.getWorldTransform() * point.m_localPointA;
  const btVector3 onB = b.getWorldTransform() * point.m_localPointB;
  Contact c;
  c.a = rigidContactPoint(found, a, onA);
  c.b = rigidContactPoint(found, b, onB);
  c.normal = toEigen(point.m_normalWorldOnB).normalized();
  c.gap = c.normal.dot(toEigen(onA) - toEigen(onB));
  c.friction = double(point.m_combinedFriction);
  c.restitution = double(point.m_combinedRestitution);
  c.positionImpulse = guess;
  ContactSource source;
  source.point = reported;
  found.add(c, source);
  addRollingRows(manifold, point, found);
}

/// m, a bound of how far the surfaces move against each other in a tick.
btScalar motionOf(const btPersistentManifold& manifold, btScalar tick) {
  btScalar motion = 0;
  for (const btCollisionObject* object : {manifold.getBody0(), manifold.getBody1()}) {
    const btRigidBody* body = btRigidBody::upcast(object);
    if (!body || isStatic(*body)) continue;
    const btScalar turn = body->getAngularVelocity().length();
    motion += tick * body->getLinearVelocity().length();
    if (turn > 0) motion += tick * turn * object->getCollisionShape()->getAngularMotionDisc();
  }
  return motion;
}

btManifoldPoint* nearest(btPersistentManifold& manifold, const btManifoldPoint& point) {
  btManifoldPoint* best = nullptr;
  const auto distance = [&](const btManifoldPoint& p) {
    return p.m_localPointA.distance2(point.m_localPointA);
  };
  for (int p = 0; p < manifold.getNumContacts(); ++p) {
    btManifoldPoint& candidate = manifold.getContactPoint(p);
    if (!best || distance(candidate) < distance(*best)) best = &candidate;
  }
  return best;
}

/// Also with points that Bullet has given up. What these bear is reported at those next to them.
void addStoredContacts(TickContacts& found, btPersistentManifold& manifold, ManifoldPointHistory& kept) {
  const std::size_t extra = keepPoints(manifold, kept);
  for (int p = 0; p < manifold.getNumContacts(); ++p) {
    btManifoldPoint& point = manifold.getContactPoint(p);
    addContact(found, manifold, point, guess(point), &point);
  }
  for (std::size_t i = extra; i < kept.now.size(); ++i) {
    const btManifoldPoint& point = kept.now[i].point;
    addContact(found, manifold, point, ContactImpulse(), nearest(manifold, point));
  }
}

/// Compounds may give manifolds of their parts back while they look for contacts, a GImpact mesh does always.
bool keepsManifolds(const btCollisionObject& object) {
  const btCollisionShape& shape = *object.getCollisionShape();
  return !shape.isCompound() && shape.getShapeType() != GIMPACT_SHAPE_PROXYTYPE;
}

/// Where the bodies touch now. What the last tick left was found before they moved: a ball that rolls on it
/// would be pushed from behind. Only where the manifold stays.
void refreshManifold(btDiscreteDynamicsWorld& world, const btPersistentManifold& manifold) {
  const btCollisionObject &a = *manifold.getBody0(), &b = *manifold.getBody1();
  if (!keepsManifolds(a) || !keepsManifolds(b)) return;
  auto* proxyA = const_cast<btBroadphaseProxy*>(a.getBroadphaseHandle());
  auto* proxyB = const_cast<btBroadphaseProxy*>(b.getBroadphaseHandle());
  btBroadphasePair* pair = world.getPairCache()->findPair(proxyA, proxyB);
  if (!pair || !pair->m_algorithm) return;
  // as btCollisionDispatcher::defaultNearCallback does it, whatever the dispatcher is
  const btCollisionObject* first = static_cast<btCollisionObject*>(pair->m_pProxy0->m_clientObject);
  const btCollisionObject* second = static_cast<btCollisionObject*>(pair->m_pProxy1->m_clientObject);
  const btCollisionObjectWrapper wrapA(nullptr, first->getCollisionShape(), first, first->getWorldTransform(),
                                       -1, -1);
  const btCollisionObjectWrapper wrapB(nullptr, second->getCollisionShape(), second,
                                       second->getWorldTransform(), -1, -1);
  btManifoldResult result(&wrapA, &wrapB);
  pair->m_algorithm->processCollision(&wrapA, &wrapB, world.getDispatchInfo(), &result);
}

void addContacts(TickContacts& found, btPersistentManifold& manifold, btScalar tick,
                 ManifoldPointHistory& kept) {
  const bool knownOnly = motionOf(manifold, tick) < manifold.getContactBreakingThreshold();
  if (knownOnly) {
    addStoredContacts(found, manifold, kept);
    manifold.setContactProcessingThreshold(kLeftAlone);
  }
  for (int p = 0; p < manifold.getNumContacts(); ++p) {
    btManifoldPoint& point = manifold.getContactPoint(p);
    if (!knownOnly) addContact(found, manifold, point, ContactImpulse(), nullptr);
    point.m_appliedImpulse = point.m_appliedImpulseLateral1 = point.m_appliedImpulseLateral2 = 0;
  }
}

/// Bullet's own least speed that bounces; bodies are drawn apart as its breaking threshold tells their size.
void setSpeeds(TickContacts& found, std::size_t first, const btDiscreteDynamicsWorld& world,
               const btPersistentManifold& manifold, btScalar tick) {
  const auto& info = const_cast<btDiscreteDynamicsWorld&>(world).getSolverInfo();
  const double size = double(manifold.getContactBreakingThreshold());
  for (std::size_t i = first; i < found.contacts.size(); ++i) {
    found.contacts[i].bounceThreshold = double(info.m_restitutionVelocityThreshold);
    found.contacts[i].recoverySpeed = recoverySpeed(size, double(world.getGravity().length()), double(tick));
  }
}

/// The contacts of rigid body `number` with others that have not had their turn.
void gatherContactsOf(btDiscreteDynamicsWorld& world, std::uint32_t number, RigidManifolds& index,
                      btScalar tick, TickContacts& found) {
  const btRigidBody* body = found.rigids[number].body;
  // what else a multibody touches is left to Bullet's solver
  if (LinkBody::from(body)) return;
  const auto place = static_cast<std::size_t>(found.rigids[number].handle.index);
  for (int i = index.begin[place]; i < index.begin[place + 1]; ++i) {
    btPersistentManifold& manifold = *index.manifolds[static_cast<std::size_t>(i)];
    const btCollisionObject* other = manifold.getBody0() == body ? manifold.getBody1() : manifold.getBody0();
    const btRigidBody* rigid = btRigidBody::upcast(other);
    const std::uint32_t theirs = rigid && isFree(*rigid) ? found.find(*rigid) : TickContacts::kNone;
    if (theirs != TickContacts::kNone && theirs <= number) continue;
    refreshManifold(world, manifold);
    const std::size_t first = found.contacts.size();
    addContacts(found, manifold, tick, index.history);
    setSpeeds(found, first, world, manifold, tick);
  }
}

}  // namespace

void gatherRigidContacts(btDiscreteDynamicsWorld& world, btScalar tick, RigidManifolds& index,
                         TickContacts& found) {
  turnOver(index.history);
  if (found.rigids.empty()) return;
  fill(index, world);
  std::uint32_t next = 0;
  do {
    for (; next < found.rigids.size(); ++next) gatherContactsOf(world, next, index, tick, found);
  } while (addJoinedBodies(world, found));
  addJointRows(world, tick, found);
}

void restoreBreakingThresholds(btDispatcher& dispatcher) {
  for (int m = 0; m < dispatcher.getNumManifolds(); ++m) {
    btPersistentManifold& manifold = *dispatcher.getManifoldByIndexInternal(m);
    if (manifold.getContactProcessingThreshold() > kLeftAlone || isSoft(manifold.getBody0()) ||
        isSoft(manifold.getBody1()))
      continue;
    const btScalar own = btMin(manifold.getBody0()->getContactProcessingThreshold(),
                               manifold.getBody1()->getContactProcessingThreshold());
    manifold.setContactProcessingThreshold(own);
  }
}

void reportRigidContacts(TickContacts& contacts) {
  for (std::size_t i = 0; i < contacts.contacts.size(); ++i) {
    btManifoldPoint* point = contacts.sources[i].point;
    if (!point) continue;
    btVector3 t, u;
    btPlaneSpace1(point->m_normalWorldOnB, t, u);
    const btVector3 impulse = toBullet(contacts.contacts[i].impulse.sum);
    point->m_appliedImpulse += impulse.dot(point->m_normalWorldOnB);
    point->m_appliedImpulseLateral1 += impulse.dot(t);
    point->m_appliedImpulseLateral2 += impulse.dot(u);
  }
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
