// SPDX-License-Identifier: Zlib

// This file finds the contacts of rigid bodies that soft bodies push. It reads Bullet's manifolds, adds
// points that Bullet has dropped, and reports the contact impulses to Bullet.

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

/// Largest number of points of a manifold: two faces of boxes have 8 corners.
constexpr std::size_t kMaxPoints = 8;

bool isBefore(const StoredManifoldPoint& x, const StoredManifoldPoint& y) {
  if (x.manifold != y.manifold) return std::less<const void*>()(x.manifold, y.manifold);
  return x.order < y.order;
}

bool contains(const btPersistentManifold& manifold, const btManifoldPoint& point) {
  const btScalar same = manifold.getContactBreakingThreshold();
  for (int p = 0; p < manifold.getNumContacts(); ++p)
    if (manifold.getContactPoint(p).m_localPointA.distance2(point.m_localPointA) < same * same) return true;
  return false;
}

/// Returns whether a point is still valid, by the rule of btPersistentManifold::refreshContactPoints.
bool isStillValid(const btPersistentManifold& manifold, const btManifoldPoint& point) {
  const btScalar threshold = manifold.getContactBreakingThreshold();
  const btVector3 offset = manifold.getBody0()->getWorldTransform() * point.m_localPointA -
                           manifold.getBody1()->getWorldTransform() * point.m_localPointB;
  const btScalar gap = offset.dot(point.m_normalWorldOnB);
  return gap <= threshold && (offset - gap * point.m_normalWorldOnB).length2() <= threshold * threshold;
}

void store(const btPersistentManifold& manifold, const btManifoldPoint& point,
           std::vector<StoredManifoldPoint>& now) {
  now.push_back(
      {&manifold, manifold.getBody0(), manifold.getBody1(), static_cast<std::uint32_t>(now.size()), point});
}

/// Stores the points of `manifold`, then those of history.last that the manifold no longer has but that are
/// still valid. They go to the end of history.now. Returns the index of the first of the latter.
std::size_t storePoints(const btPersistentManifold& manifold, ManifoldPointHistory& history) {
  const std::size_t first = history.now.size();
  for (int p = 0; p < manifold.getNumContacts(); ++p)
    store(manifold, manifold.getContactPoint(p), history.now);
  const std::size_t extra = history.now.size();
  const auto isEarlier = [](const StoredManifoldPoint& k, const btPersistentManifold* m) {
    return std::less<const void*>()(k.manifold, m);
  };
  auto k = std::lower_bound(history.last.begin(), history.last.end(), &manifold, isEarlier);
  for (; k != history.last.end() && k->manifold == &manifold; ++k) {
    if (k->a != manifold.getBody0() || k->b != manifold.getBody1()) continue;
    if (contains(manifold, k->point) || !isStillValid(manifold, k->point)) continue;
    if (history.now.size() - first < kMaxPoints) store(manifold, k->point, history.now);
  }
  return extra;
}

/// Starts a tick: the points stored in the last one become history.last, sorted.
void startTick(ManifoldPointHistory& history) {
  history.last.swap(history.now);
  history.now.clear();
  std::sort(history.last.begin(), history.last.end(), isBefore);
}

}  // namespace

// --- contacts ----------------------------------------------------------------------------------------------

namespace {

/// Calls visit(index in the world's list, manifold) for both objects of all manifolds with a contact
/// response.
template <class Visit>
void forEachSide(btDispatcher& dispatcher, Visit visit) {
  forEachManifold(dispatcher, [&](btPersistentManifold& manifold) {
    const btCollisionObject *a = manifold.getBody0(), *b = manifold.getBody1();
    if (manifold.getNumContacts() == 0 || isSoft(a) || isSoft(b)) return;
    if (!a->hasContactResponse() || !b->hasContactResponse()) return;
    for (const btCollisionObject* object : {a, b})
      if (object->getWorldArrayIndex() >= 0)
        visit(static_cast<std::size_t>(object->getWorldArrayIndex()), &manifold);
  });
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

/// Returns the impulse of the last tick as a first guess. It is spread over the solves later: there are two
/// per substep, and their number is not known yet.
ContactImpulse guess(const btManifoldPoint& point) {
  btVector3 t, u;
  btPlaneSpace1(point.m_normalWorldOnB, t, u);
  return {double(point.m_appliedImpulse),
          toEigen(t * point.m_appliedImpulseLateral1 + u * point.m_appliedImpulseLateral2)};
}

/// The contact's impulse is added to `reported`, which may be null.
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

/// Returns an upper bound (m) of the relative motion of the surfaces in a tick.
btScalar relativeMotion(const btPersistentManifold& manifold, btScalar tick) {
  btScalar motion = 0;
  for (const btCollisionObject* object : {manifold.getBody0(), manifold.getBody1()}) {
    const btRigidBody* body = btRigidBody::upcast(object);
    if (!body || isStatic(*body)) continue;
    motion += tick * (body->getLinearVelocity().length() + rotationSpeed(*body));
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

/// Adds the manifold's points and those that Bullet has dropped. The impulses of the latter are reported at
/// the nearest point.
void addStoredContacts(TickContacts& found, btPersistentManifold& manifold, ManifoldPointHistory& history) {
  const std::size_t extra = storePoints(manifold, history);
  for (int p = 0; p < manifold.getNumContacts(); ++p) {
    btManifoldPoint& point = manifold.getContactPoint(p);
    addContact(found, manifold, point, guess(point), &point);
  }
  for (std::size_t i = extra; i < history.now.size(); ++i) {
    const btManifoldPoint& point = history.now[i].point;
    addContact(found, manifold, point, ContactImpulse(), nearest(manifold, point));
  }
}

/// Returns whether the object's manifolds stay during a search for contacts. Compounds may free manifolds of
/// their children, and a GImpact mesh always does.
bool keepsManifolds(const btCollisionObject& object) {
  const btCollisionShape& shape = *object.getCollisionShape();
  return !shape.isCompound() && shape.getShapeType() != GIMPACT_SHAPE_PROXYTYPE;
}

/// Runs Bullet's narrowphase again for two bodies, if their manifold stays. The points of the last tick were
/// found before the bodies moved: they would push a rolling ball from behind.
void refreshManifold(btDiscreteDynamicsWorld& world, const btPersistentManifold& manifold) {
  const btCollisionObject &a = *manifold.getBody0(), &b = *manifold.getBody1();
  if (!keepsManifolds(a) || !keepsManifolds(b)) return;
  auto* proxyA = const_cast<btBroadphaseProxy*>(a.getBroadphaseHandle());
  auto* proxyB = const_cast<btBroadphaseProxy*>(b.getBroadphaseHandle());
  btBroadphasePair* pair = world.getPairCache()->findPair(proxyA, proxyB);
  if (!pair || !pair->m_algorithm) return;
  // as in btCollisionDispatcher::defaultNearCallback, for any dispatcher
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
                 ManifoldPointHistory& history) {
  const bool isSlow = relativeMotion(manifold, tick) < manifold.getContactBreakingThreshold();
  if (isSlow) {
    addStoredContacts(found, manifold, history);
    manifold.setContactProcessingThreshold(kIgnoredByBullet);
  }
  for (int p = 0; p < manifold.getNumContacts() && !isSlow; ++p)
    addContact(found, manifold, manifold.getContactPoint(p), ContactImpulse(), nullptr);
  clearImpulses(manifold);
}

/// Sets Bullet's own bounce threshold, and a recovery speed for the size that its breaking threshold gives.
void setSpeeds(TickContacts& found, std::size_t first, const btDiscreteDynamicsWorld& world,
               const btPersistentManifold& manifold, btScalar tick) {
  const auto& info = const_cast<btDiscreteDynamicsWorld&>(world).getSolverInfo();
  const double size = double(manifold.getContactBreakingThreshold());
  for (std::size_t i = first; i < found.contacts.size(); ++i) {
    found.contacts[i].bounceThreshold = double(info.m_restitutionVelocityThreshold);
    found.contacts[i].recoverySpeed = recoverySpeed(size, double(world.getGravity().length()), double(tick));
  }
}

/// Adds the contacts of rigid body `number` with others, except those that earlier bodies have added.
void gatherContactsOf(btDiscreteDynamicsWorld& world, std::uint32_t number, RigidManifolds& index,
                      btScalar tick, TickContacts& found) {
  const btRigidBody* body = found.rigids[number].body;
  // Bullet's solver handles the other contacts of a multibody
  if (LinkBody::from(body)) return;
  const auto objectIndex = static_cast<std::size_t>(found.rigids[number].handle.index);
  for (int i = index.begin[objectIndex]; i < index.begin[objectIndex + 1]; ++i) {
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
  startTick(index.history);
  if (found.rigids.empty()) return;
  fill(index, world);
  std::uint32_t next = 0;
  do {
    for (; next < found.rigids.size(); ++next) gatherContactsOf(world, next, index, tick, found);
  } while (addJoinedBodies(world, found));
  addJointRows(world, tick, found);
}

void restoreBreakingThresholds(btDispatcher& dispatcher) {
  // see gatherContacts() for the thresholds of points in a tick
  const auto ownOf = [](const btCollisionObject* object) {
    return PointMass::from(object) ? btScalar(BT_LARGE_FLOAT) : object->getContactProcessingThreshold();
  };
  forEachManifold(dispatcher, [&](btPersistentManifold& manifold) {
    const btCollisionObject *a = manifold.getBody0(), *b = manifold.getBody1();
    if (manifold.getContactProcessingThreshold() > kIgnoredByBullet || SurfaceObject::from(a) ||
        SurfaceObject::from(b))
      return;
    manifold.setContactProcessingThreshold(btMin(ownOf(a), ownOf(b)));
  });
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
