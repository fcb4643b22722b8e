// SPDX-License-Identifier: Zlib

// This file numbers the rigid bodies in the contacts of a tick and stores the contact impulses. It makes the
// contacts of rigid bodies that soft bodies push from Bullet's manifolds, adds points that Bullet has
// dropped, and reports the impulses to Bullet.

#include "bullet/tick_contacts.h"

#include "bullet/kinematic_motion.h"
#include "bullet/point_contacts.h"

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

// --- the contacts of a tick --------------------------------------------------------------------------------

std::uint32_t TickContacts::find(const btRigidBody& body) const {
  const auto index = static_cast<std::size_t>(body.getWorldArrayIndex());
  return index < numbers_.size() ? numbers_[index] : kNone;
}

std::uint32_t TickContacts::add(btRigidBody& body) {
  if (const std::uint32_t number = find(body); number != kNone) return number;
  const auto index = static_cast<std::size_t>(body.getWorldArrayIndex());
  if (index >= numbers_.size()) numbers_.resize(index + 1, kNone);
  numbers_[index] = static_cast<std::uint32_t>(rigids.size());
  rigids.push_back(makePartner(body));
  return numbers_[index];
}

void TickContacts::clear(double comingTick) {
  tick = comingTick;
  for (const RigidPartner& rigid : rigids) numbers_[static_cast<std::size_t>(rigid.handle.index)] = kNone;
  rigids.clear();
  contacts.clear();
  sensed.clear();
  candidates.clear();
  waiting.clear();
  joints.clear();
  jointSources.clear();
}

Eigen::Vector3d velocityOf(const btCollisionObject& object, const btVector3& position, double tick) {
  if (isKinematic(object)) return kinematicDisplacement(object, toEigen(position)) / tick;
  const btRigidBody* rigid = btRigidBody::upcast(&object);
  if (!rigid || rigid->isStaticObject() || !rigid->isActive()) return Eigen::Vector3d::Zero();
  return toEigen(rigid->getVelocityInLocalPoint(position - rigid->getWorldTransform().getOrigin()));
}

ContactPoint rigidContactPoint(TickContacts& contacts, const btCollisionObject& object,
                               const btVector3& position) {
  ContactPoint found;
  btRigidBody* rigid = btRigidBody::upcast(const_cast<btCollisionObject*>(&object));
  if (rigid && isFree(*rigid)) {
    found.kind = ContactPoint::Kind::Rigid;
    found.body = contacts.add(*rigid);
    found.arm = toEigen(position) - toEigen(rigid->getWorldTransform().getOrigin());
  } else {
    found.velocity = velocityOf(object, position, contacts.tick);
  }
  return found;
}

Eigen::Vector3d positionOf(const ContactPoint& point, const Points& positions) {
  Eigen::Vector3d x = Eigen::Vector3d::Zero();
  for (std::uint32_t i = 0; i < point.count; ++i) x += point.weight[i] * positions.col(point.point[i]);
  return x;
}

void setMaterial(ContactBase& contact, const btCollisionObject& a, const btCollisionObject& b,
                 const ContactSpeeds& speeds) {
  contact.friction = double(gCalculateCombinedFrictionCallback(&a, &b));
  contact.restitution = double(gCalculateCombinedRestitutionCallback(&a, &b));
  contact.bounceThreshold = speeds.bounce;
  contact.recoverySpeed = speeds.recovery;
}

// --- impulses of the last tick -----------------------------------------------------------------------------

namespace {

bool isBefore(const StoredImpulse& k, const StoredImpulse& l) {
  return std::pair(k.partner, k.key) < std::pair(l.partner, l.key);
}

/// Returns the impulse of the contact in the last tick, or nullptr.
const ContactImpulse* lastImpulse(const SoftBodyData& body, const ObjectHandle& partner, std::uint64_t key) {
  const std::vector<StoredImpulse>& stored = body.storedImpulses;
  const StoredImpulse wanted{partner.id, partner.object, key, {}};
  const auto it = std::lower_bound(stored.begin(), stored.end(), wanted, isBefore);
  const bool found = it != stored.end() && !isBefore(wanted, *it) && it->object == wanted.object;
  return found ? &it->impulse : nullptr;
}

/// The impulse is relative to the normal at the start of the tick, as the next tick's search finds it: its
/// direction may have changed since.
void store(SoftBodyData& body, const ObjectHandle& partner, std::uint64_t key, const ContactBase& c) {
  const double along = c.normal.dot(c.impulse.sum);
  body.storedImpulses.push_back({partner.id, partner.object, key, {along, c.impulse.sum - along * c.normal}});
}

/// Returns the key of a row of the body's contacts: the point, and how many rows before it have the same
/// point and partner. No key of two features is as large.
std::uint64_t planeKey(const SoftBodyData& body, std::size_t index) {
  const std::uint32_t point = body.contacts[index].point;
  std::uint64_t before = 0;
  for (std::size_t i = index; i-- > 0 && body.contacts[i].point == point;)
    before += body.contacts[i].partner == body.contacts[index].partner;
  return std::uint64_t{0xf} << 60 | before << 32 | point;
}

/// Notes the acceleration (m/s^2) of points if a contact that exerted `impulse` (N s) on them ended.
void noteRelease(SoftBodyData& body, std::uint32_t point, double impulse, double tick) {
  const double w = body.state.inverseMass.col(point).maxCoeff();
  body.surface.release = std::max(body.surface.release, w * impulse / tick);
}

void noteReleases(const TickContact& c, double tick) {
  for (const auto& [point, body] : {std::pair(&c.a, c.source.body), std::pair(&c.b, c.source.other)})
    for (std::uint32_t i = 0; body && point->kind == ContactPoint::Kind::Soft && i < point->count; ++i)
      noteRelease(*body, point->point[i], point->weight[i] * c.impulse.along, tick);
}

}  // namespace

void warmStart(TickContacts& contacts) {
  for (TickContact& c : contacts.contacts) {
    if (!c.source.body) continue;
    if (const ContactImpulse* impulse = lastImpulse(*c.source.body, c.source.partner, c.source.key))
      c.positionImpulse = *impulse;
  }
}

void warmStart(const SoftBodyData& body, std::size_t index, Contact& contact) {
  const ObjectHandle& partner = partnerOf(body, body.contacts[index]).handle;
  if (const ContactImpulse* impulse = lastImpulse(body, partner, planeKey(body, index)))
    contact.positionImpulse = *impulse;
}

void storeImpulses(const std::vector<SoftBodyData*>& bodies, const TickContacts& contacts) {
  for (SoftBodyData* body : bodies) {
    body->storedImpulses.clear();
    body->surface.release = 0.0;
    for (std::size_t i = 0; i < body->contacts.size(); ++i) {
      const PlaneContact& row = body->contacts[i];
      if (!(row.impulse.along > 0.0)) continue;
      noteRelease(*body, row.point, row.impulse.along, contacts.tick);
      if (row.coupled) store(*body, partnerOf(*body, row).handle, planeKey(*body, i), row);
    }
  }
  for (const TickContact& c : contacts.contacts) {
    if (!c.source.body) continue;
    store(*c.source.body, c.source.partner, c.source.key, c);
    noteReleases(c, contacts.tick);
  }
  for (SoftBodyData* body : bodies) sortImpulses(body->storedImpulses);
}

void sortImpulses(std::vector<StoredImpulse>& impulses) {
  std::sort(impulses.begin(), impulses.end(), isBefore);
}

// --- points of manifolds -----------------------------------------------------------------------------------

namespace {

/// Largest number of points of a manifold: two faces of boxes have 8 corners.
constexpr std::size_t kMaxPoints = 8;

/// Returns the manifold's point that is nearest to `point` on its first object, or nullptr.
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

bool contains(btPersistentManifold& manifold, const btManifoldPoint& point) {
  const btScalar same = manifold.getContactBreakingThreshold();
  const btManifoldPoint* best = nearest(manifold, point);
  return best && best->m_localPointA.distance2(point.m_localPointA) < same * same;
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
std::size_t storePoints(btPersistentManifold& manifold, RigidManifolds& history) {
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
void startTick(RigidManifolds& history) {
  history.last.swap(history.now);
  history.now.clear();
  std::sort(history.last.begin(), history.last.end(),
            [](const StoredManifoldPoint& x, const StoredManifoldPoint& y) {
              return x.manifold != y.manifold ? std::less<const void*>()(x.manifold, y.manifold)
                                              : x.order < y.order;
            });
}

// --- contacts ----------------------------------------------------------------------------------------------

/// Calls visit(index in the world's list, manifold) for both objects of all manifolds with a contact
/// response. Manifolds of spheres may be empty: they have a point only while the two overlap.
template <class Visit>
void forEachSide(btDispatcher& dispatcher, Visit visit) {
  forEachManifold(dispatcher, [&](btPersistentManifold& manifold) {
    const btCollisionObject *a = manifold.getBody0(), *b = manifold.getBody1();
    if (isSoft(a) || isSoft(b)) return;
    if (manifold.getNumContacts() == 0 && !(isSphere(*a) && isSphere(*b))) return;
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

/// Completes the motion of a point on a kinematic object that turns.
void setTurn(ContactPoint& side, const btCollisionObject& object, const Eigen::Vector3d& normal,
             double tick) {
  if (side.kind != ContactPoint::Kind::World || !isKinematic(object)) return;
  const SurfaceVelocity motion = surfaceVelocityOf(object, tick * side.velocity, normal, tick);
  side.velocity = motion.velocity, side.acceleration = motion.acceleration;
}

}  // namespace

void addRigidContact(TickContacts& found, const btCollisionObject& a, const btCollisionObject& b,
                     const btManifoldPoint& point, const ContactSpeeds& speeds, const ContactImpulse& guess,
                     btManifoldPoint* reported) {
  const btVector3 onA = a.getWorldTransform() * point.m_localPointA;
  const btVector3 onB = b.getWorldTransform() * point.m_localPointB;
  TickContact c;
  c.a = rigidContactPoint(found, a, onA);
  c.b = rigidContactPoint(found, b, onB);
  c.normal = toEigen(point.m_normalWorldOnB).normalized();
  setTurn(c.a, a, c.normal, found.tick);
  setTurn(c.b, b, c.normal, found.tick);
  c.gap = c.normal.dot(toEigen(onA) - toEigen(onB));
  c.friction = double(point.m_combinedFriction);
  c.restitution = double(point.m_combinedRestitution);
  c.bounceThreshold = speeds.bounce;
  c.recoverySpeed = speeds.recovery;
  c.positionImpulse = guess;
  c.source.point = reported;
  found.contacts.push_back(c);
  addRollingRows(a, b, point, found);
}

namespace {

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

/// Adds the manifold's points. If the bodies are slow, also adds those that Bullet has dropped, and Bullet's
/// solver ignores the manifold. The impulses of dropped points are reported at the nearest point.
void addContacts(TickContacts& found, btPersistentManifold& manifold, const ContactSpeeds& speeds,
                 btScalar tick, RigidManifolds& history) {
  const btCollisionObject &a = *manifold.getBody0(), &b = *manifold.getBody1();
  const bool isSlow = relativeMotion(manifold, tick) < manifold.getContactBreakingThreshold();
  const std::size_t extra = isSlow ? storePoints(manifold, history) : history.now.size();
  for (int p = 0; p < manifold.getNumContacts(); ++p) {
    btManifoldPoint& point = manifold.getContactPoint(p);
    addRigidContact(found, a, b, point, speeds, isSlow ? guess(point) : ContactImpulse(),
                    isSlow ? &point : nullptr);
  }
  for (std::size_t i = extra; i < history.now.size(); ++i) {
    const btManifoldPoint& point = history.now[i].point;
    addRigidContact(found, a, b, point, speeds, ContactImpulse(), nearest(manifold, point));
  }
  if (isSlow) manifold.setContactProcessingThreshold(kIgnoredByBullet);
  clearImpulses(manifold);
}

/// Returns Bullet's own bounce threshold, and a recovery speed for a `size` (m).
ContactSpeeds rigidSpeeds(const btDiscreteDynamicsWorld& world, double size, btScalar tick) {
  return {recoverySpeed(size, double(world.getGravity().length()), double(tick)),
          double(world.getSolverInfo().m_restitutionVelocityThreshold)};
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
    // the breaking threshold depends on the size
    const ContactSpeeds speeds = rigidSpeeds(world, double(manifold.getContactBreakingThreshold()), tick);
    addContacts(found, manifold, speeds, tick, index);
  }
}

}  // namespace

void gatherRigidContacts(btDiscreteDynamicsWorld& world, const MovingObjects& objects, btScalar tick,
                         RigidManifolds& index, TickContacts& found) {
  startTick(index);
  addJointedSurfaces(world, found);
  if (found.rigids.empty()) return;
  fill(index, world);
  const double reach = longestWay(objects, double(tick));
  const ContactSpeeds speeds = rigidSpeeds(world, double(gContactBreakingThreshold), tick);
  std::uint32_t next = 0;
  do {
    for (; next < found.rigids.size(); ++next) {
      // those of soft bodies are found apart
      if (SurfaceObject::from(found.rigids[next].body)) continue;
      gatherContactsOf(world, next, index, tick, found);
      addComingContacts(world, next, reach, speeds, index, found);
    }
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
  for (const TickContact& c : contacts.contacts) {
    btManifoldPoint* point = c.source.point;
    if (!point) continue;
    btVector3 t, u;
    btPlaneSpace1(point->m_normalWorldOnB, t, u);
    const btVector3 impulse = toBullet(c.impulse.sum);
    point->m_appliedImpulse += impulse.dot(point->m_normalWorldOnB);
    point->m_appliedImpulseLateral1 += impulse.dot(t);
    point->m_appliedImpulseLateral2 += impulse.dot(u);
  }
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
