// SPDX-License-Identifier: Zlib

// This file is Collision::Points: the point masses of a body are in the world. It writes their motion to
// Bullet's bodies and reads the impulses of Bullet's solver from them, stops fast points at the first object
// in their path, finds contacts with points of other bodies, and reads and writes Bullet's manifolds.

#include "bullet/contact_report.h"
#include "bullet/linked_group.h"
#include "bullet/point_contacts.h"

#include <BulletCollision/CollisionDispatch/btSphereBoxCollisionAlgorithm.h>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {
namespace {

/// Number of rounding errors that Bullet makes between a write to its bodies and a read. Differences up to
/// this many units in the last place are not an impulse.
constexpr double kMaxRoundings = 4.0;
constexpr double kEpsilon = std::numeric_limits<btScalar>::epsilon();

/// Returns zero if `v` is not larger than the rounding error of quantities of the size `scale`.
Eigen::Vector3d withoutRounding(const Eigen::Vector3d& v, double scale) {
  const double noise = kMaxRoundings * kEpsilon * scale;
  return v.cwiseAbs().maxCoeff() <= noise ? Eigen::Vector3d::Zero() : v;
}

/// Returns the acceleration (m/s^2) that Bullet itself gives the point.
Eigen::Vector3d ownAcceleration(const PointMass& point) {
  return toEigen(point.getTotalForce()) * double(point.getInvMass());
}

void readFreePoint(SoftBodyData& body, std::uint32_t i, btScalar tick) {
  const PointMass& point = *body.masses.bodies[i];
  const btVector3& expected = body.masses.expectedVelocity[i];
  const btVector3& start = body.masses.leftPosition[i];
  const btVector3& origin = point.getWorldTransform().getOrigin();
  const btVector3& velocity = point.getLinearVelocity();

  const double speed = toEigen(expected).cwiseAbs().maxCoeff();
  const Eigen::Vector3d impulse = withoutRounding(difference(velocity, expected), speed);
  const Eigen::Vector3d unexplained = difference(origin, start) - double(tick) * toEigen(velocity);
  const double size = toEigen(origin).cwiseAbs().maxCoeff() + double(tick) * toEigen(velocity).norm();
  body.state.velocity.col(i) += impulse;
  body.state.position.col(i) += double(tick) * impulse + withoutRounding(unexplained, size);
}

/// Gives a point the gravity of the settings in place of the world's, which the world has already applied.
void scaleGravity(PointMass& point, const btVector3& gravity) {
  if ((point.getFlags() & BT_DISABLE_WORLD_GRAVITY) != 0 || point.getGravity() == gravity) return;
  if (point.getInvMass() > btScalar(0))
    point.applyCentralForce((gravity - point.getGravity()) / point.getInvMass());
  point.setGravity(gravity);
}

}  // namespace

void addPointMasses(SoftBodyData& body) {
  initializePointMasses(body);
  makePointMasses(body);
  body.masses.exposed = true;
  for (PointMass* point : body.masses.bodies)
    body.world->addRigidBody(point, body.settings.collisionGroup, body.settings.collisionMask);
}

void removePointMasses(SoftBodyData& body) {
  // from the back: Bullet finds a body in its list of dynamic bodies by a linear search and replaces it by
  // the last
  for (std::size_t i = body.masses.bodies.size(); i-- > 0;) {
    PointMass* point = body.masses.bodies[i];
    // the world's destructor removes the broadphase handle: a body without one must not access the world
    if (point && point->isInWorld()) body.world->removeRigidBody(point);
  }
  deletePointMasses(body);
}

void gatherWorldPoints(SoftBodyData& body, btScalar tick) {
  gatherPoints(body, tick, false);
  if (body.settings.gravityFactor != 1.0)
    for (PointMass* point : body.masses.bodies) scaleGravity(*point, gravityOf(body));
  for (std::uint32_t i = 0; i < body.masses.bodies.size(); ++i) {
    PointMass& point = *body.masses.bodies[i];
    if (!isSound(point.getTotalForce())) {
      point.clearForces();
      point.applyGravity();
      body.restored = true;
    }
    body.state.acceleration.col(i) = ownAcceleration(point);
    if (body.masses.held[i]) body.state.acceleration.col(i).setZero();
  }
}

void writeVelocitiesToBullet(SoftBodyData& body, btScalar tick) {
  PointMasses& m = body.masses;
  m.inFlight = true, m.placed = false;
  for (std::uint32_t i = 0; i < m.bodies.size(); ++i) {
    if (m.held[i]) continue;
    PointMass& point = *m.bodies[i];
    const Eigen::Vector3d mean = (body.state.position.col(i) - m.startPosition.col(i)) / double(tick);
    const btVector3 written = toBullet(mean - double(tick) * ownAcceleration(point));
    point.setLinearVelocity(written);
    // in the arithmetic of btSequentialImpulseConstraintSolver
    m.expectedVelocity[i] = written + point.getTotalForce() * point.getInvMass() * tick;
  }
}

void wakeWorldPoints(SoftBodyData& body, bool insideTick) {
  for (PointMass* point : body.masses.bodies) {
    if (!point || point->isActive()) continue;
    if (insideTick)
      wakeInStep(*point);
    else
      point->activate(true);
  }
}

// --- continuous collision ----------------------------------------------------------------------------------

namespace {

/// Returns whether Bullet has a kinematic object already at its pose at the end of the tick. All other
/// objects are at their start, so those that it carries are inside it.
bool isAtEndPose(const btCollisionObject& object) {
  return isKinematic(object) && !(object.getWorldTransform() == object.getInterpolationWorldTransform() &&
                                  object.getInterpolationLinearVelocity().isZero() &&
                                  object.getInterpolationAngularVelocity().isZero());
}

/// Fraction of the radius that a point may move in a tick without a sweep. Its centre then stays on the
/// correct side of surfaces that it has not touched yet.
constexpr double kMaxUnsweptMotion = 0.25;

/// Fraction of the radius that is swept, so that a point at rest does not hit its support.
constexpr double kSweptRadius = 0.9;

struct FirstHit final : btCollisionWorld::ClosestConvexResultCallback {
  FirstHit(const SoftBodyData& b, const PointMass& p, const btVector3& from, const btVector3& to)
      : ClosestConvexResultCallback(from, to), body(&b), point(&p) {}
  const SoftBodyData* body;
  const PointMass* point;

  bool needsCollision(btBroadphaseProxy* proxy) const override {
    const auto* object = static_cast<const btCollisionObject*>(proxy->m_clientObject);
    return !isAtEndPose(*object) && canHit(*body, *object) && canHit(*body, point->index(), *object);
  }
};

double motion(const SoftBodyData& body, Eigen::Index i) {
  return (body.state.position.col(i) - body.masses.startPosition.col(i)).norm();
}

/// Returns whether the body may have passed through an object in the tick.
bool hasObstacle(const SoftBodyData& body, double longest) {
  bool any = false;
  forEachObjectIn(*body.world, boxAround(body.masses.startPosition, radiusOf(body) + longest),
                  [&](const btCollisionObject& object) { any = any || canHit(body, object); });
  return any;
}

void sweepPoint(SoftBodyData& body, Eigen::Index i) {
  const PointMass& point = *body.masses.bodies[static_cast<std::size_t>(i)];
  const Eigen::Vector3d start = body.masses.startPosition.col(i), end = body.state.position.col(i);
  btTransform from(btQuaternion::getIdentity(), toBullet(start)),
      to(btQuaternion::getIdentity(), toBullet(end));
  FirstHit hit(body, point, from.getOrigin(), to.getOrigin());
  const btSphereShape sphere(static_cast<btScalar>(kSweptRadius) * body.masses.shape->getRadius());
  body.world->convexSweepTest(&sphere, from, to, hit, btScalar(0));
  if (!hit.hasHit() || !(toEigen(hit.m_hitNormalWorld).dot(end - start) < 0.0)) return;
  body.state.position.col(i) = start + double(hit.m_closestHitFraction) * (end - start);
}

/// Moves point masses in the world that have moved farther in this tick than contacts were searched for to
/// their first contact. Their velocity does not change: the next tick finds the contact. Call it after
/// Bullet's contacts have been read, when start and end positions are known, and before the bodies are
/// written.
///
/// Only points that move far enough to miss a contact are swept, and only if an object is in the box of the
/// body's motion (one broadphase query per body). Bullet's own continuous collision is not used. It sweeps
/// twice, without such a query, and on triangle meshes it ignores all motions into the surface that are
/// shorter than the world's m_allowedCcdPenetration (4 cm), twice the size of a point mass.
void stopAtFirstContact(SoftBodyData& body) {
  if (!body.settings.continuousCollision) return;
  const double unswept = kMaxUnsweptMotion * radiusOf(body);
  const auto isUnexpected = [&](Eigen::Index i) {
    const auto at = static_cast<std::size_t>(i);
    return !body.masses.held[at] && motion(body, i) > std::max(unswept, body.searchDistance[at]);
  };
  double longest = 0.0;
  for (Eigen::Index i = 0; i < body.state.position.cols(); ++i)
    if (isUnexpected(i)) longest = std::max(longest, motion(body, i));
  if (!(longest > 0.0) || !hasObstacle(body, longest)) return;
  for (Eigen::Index i = 0; i < body.state.position.cols(); ++i)
    if (isUnexpected(i)) sweepPoint(body, i);
}

}  // namespace

void finishWorldPoints(SoftBodyData& body, btScalar tick) {
  for (PointMass* point : body.masses.bodies) point->setContactProcessingThreshold(BT_LARGE_FLOAT);
  body.masses.inFlight = false;
  for (std::uint32_t i = 0; !body.masses.placed && i < body.masses.bodies.size(); ++i)
    if (!body.masses.held[i]) readFreePoint(body, i, tick);
  body.sumsValid = false;
  restoreIfUnsound(body);
  if (!body.masses.placed) stopAtFirstContact(body);
  writePoints(body);
}

// --- contacts with points of other bodies ------------------------------------------------------------------

namespace {

ContactPoint contactPointOf(const PointMass& point) {
  ContactPoint result = softPoint(point.owner()->index, point.index());
  if (point.owner()->asleep) result.kind = ContactPoint::Kind::World;
  return result;
}

Contact contactOf(const PointMass& point, const PointMass& other, const Eigen::Vector3d& normal,
                  const Eigen::Vector3d& offset, double radiusSum) {
  const SoftBodyData &body = *point.owner(), &theirs = *other.owner();
  Contact c;
  c.a = contactPointOf(point);
  c.b = contactPointOf(other);
  c.normal = normal;
  c.gap = normal.dot(offset) - radiusSum;
  c.spheres = theirs.asleep ? 0.0 : radiusSum;
  setMaterial(c, point, other, body.speeds);
  if (!theirs.asleep) c.recoverySpeed = std::min(c.recoverySpeed, theirs.speeds.recovery);
  return c;
}

/// Returns a column of a velocity or acceleration; 0 for a sleeping body, which is not stepped.
Eigen::Vector3d movingColumn(const PointMass& point, const Points& quantity) {
  if (point.owner()->asleep) return Eigen::Vector3d::Zero();
  return quantity.col(point.index());
}

/// Moves the last contact to its place by the partners' ids among those from `first` on. The broadphase finds
/// them in an order that depends on earlier ticks.
void sortLastContact(TickContacts& found, std::size_t first) {
  for (std::size_t i = found.contacts.size() - 1; i > first; --i) {
    if (found.contacts[i - 1].source.partner.id <= found.contacts[i].source.partner.id) return;
    std::swap(found.contacts[i - 1], found.contacts[i]);
  }
}

/// Adds the contact of two points if they may touch in the tick (s). Those from `first` on are sorted.
void addIfNear(const PointMass& point, const PointMass& other, double tick, std::size_t first,
               TickContacts& found) {
  const PointState &ours = point.owner()->state, &theirs = other.owner()->state;
  const Eigen::Vector3d offset = ours.position.col(point.index()) - theirs.position.col(other.index());
  const Eigen::Vector3d velocity = movingColumn(point, ours.velocity) - movingColumn(other, theirs.velocity);
  const double change =
      tick * tick *
      (movingColumn(point, ours.acceleration) - movingColumn(other, theirs.acceleration)).norm();
  const double radiusSum = radiusOf(*point.owner()) + radiusOf(*other.owner());
  if (offset.norm() - radiusSum > kSearchPerMotion * (tick * velocity.norm() + change) + radiusSum / 3.0)
    return;
  const Eigen::Vector3d nearest = offsetWhenNearest(offset, velocity, tick, radiusSum);
  if (!(nearest.norm() > 0.0)) return;
  found.contacts.push_back({contactOf(point, other, nearest.normalized(), offset, radiusSum),
                            {nullptr, point.owner(), other.owner(), handleOf(other), point.index()}});
  sortLastContact(found, first);
}

/// Calls visit(point) for the points of other bodies whose boxes overlap the region.
template <class Visit>
void forEachOtherPoint(const SoftBodyData& body, const Eigen::AlignedBox3d& box, Visit visit) {
  forEachObjectIn(*body.world, box, [&](const btCollisionObject& object) {
    const PointMass* other = PointMass::from(&object);
    if (other && other->owner() != &body) visit(*other);
  });
}

/// Adds the contacts of a body's points. No point moves farther than `farthest` (m) towards another one.
void addPointPairs(const SoftBodyData& body, double tick, double farthest, TickContacts& found) {
  Eigen::AlignedBox3d box;
  for (std::uint32_t i = 0; i < body.masses.bodies.size(); ++i)
    box.extend(searchRegionOf(body, i, tick, farthest).box);
  bool any = false;
  forEachOtherPoint(body, box, [&](const PointMass&) { any = true; });
  if (!any) return;
  for (std::uint32_t i = 0; i < body.masses.bodies.size(); ++i) {
    const std::size_t first = found.contacts.size();
    forEachOtherPoint(body, searchRegionOf(body, i, tick, farthest).box, [&](const PointMass& other) {
      const SoftBodyData* theirs = other.owner();
      if (!theirs || !theirs->alive) return;
      // the other body adds the contact
      if (!theirs->asleep && theirs->index < body.index) return;
      if (canHit(body, other) && canHit(body, i, other))
        addIfNear(*body.masses.bodies[i], other, tick, first, found);
    });
  }
}

}  // namespace

void gatherPointPairs(const AwakeGroups& groups, btScalar tick, TickContacts& found) {
  double farthest = 0.0;
  for (const LinkedGroup* group : groups)
    for (const SoftBodyData* body : group->bodies)
      if (!isSurfaceBody(*body))
        farthest =
            std::max(farthest, *std::max_element(body->searchDistance.begin(), body->searchDistance.end()));
  for (const LinkedGroup* group : groups)
    for (const SoftBodyData* body : group->bodies)
      if (!isSurfaceBody(*body)) addPointPairs(*body, double(tick), farthest, found);
}

// --- Bullet's contacts with points -------------------------------------------------------------------------

namespace {

/// Calls visit(manifold, point, partner) for all manifolds of point masses.
template <class Visit>
void forEachPointManifold(btDispatcher& dispatcher, Visit visit) {
  forEachManifold(dispatcher, [&](btPersistentManifold& manifold) {
    PointMass* first = PointMass::from(const_cast<btCollisionObject*>(manifold.getBody0()));
    PointMass* point = first ? first : PointMass::from(const_cast<btCollisionObject*>(manifold.getBody1()));
    if (point && point->owner())
      visit(manifold, *point, *(first ? manifold.getBody1() : manifold.getBody0()));
  });
}

bool isStepped(const PointMass& point) { return point.owner()->alive && !point.owner()->asleep; }

/// Returns whether both objects are points of living soft bodies, at least one of them awake:
/// gatherPointPairs() adds their contacts.
bool isBetweenAwakePoints(const PointMass& point, const btCollisionObject& partner) {
  const PointMass* other = PointMass::from(&partner);
  return other && other->owner() && point.owner()->alive && other->owner()->alive &&
         (isStepped(point) || isStepped(*other));
}

bool hasRows(const PointMass& point, const btCollisionObject& partner) {
  const SoftBodyData& body = *point.owner();
  const ContactRange rows = contactsOfPoint(body.contacts, point.index());
  const PlaneContact* contacts = body.contacts.data();
  return std::any_of(contacts + rows.begin, contacts + rows.end,
                     [&](const PlaneContact& row) { return partnerOf(body, row).handle.object == &partner; });
}

}  // namespace

void readManifolds(btDispatcher& dispatcher) {
  forEachPointManifold(
      dispatcher, [](btPersistentManifold& manifold, PointMass& point, const btCollisionObject& partner) {
        const bool betweenPoints = isBetweenAwakePoints(point, partner);
        if (!betweenPoints && (!isStepped(point) || !isStaticOrKinematic(partner))) return;
        const btCollisionShape& shape = *partner.getCollisionShape();
        const bool isSimple = manifold.getNumContacts() == 1 && !shape.isConcave() && !shape.isCompound();
        if (isSimple && !betweenPoints) point.cachedContact = &manifold;
        clearImpulses(manifold);
      });
}

void disableBulletResponse(btDispatcher& dispatcher) {
  forEachPointManifold(dispatcher, [](btPersistentManifold& manifold, const PointMass& point,
                                      const btCollisionObject& partner) {
    // where an object is at its end pose, Bullet would push the point out of that
    const bool onOwnRows = isStepped(point) && (isAtEndPose(partner) || hasRows(point, partner));
    // a contact without rows is one that the user's filter has removed
    const bool onFilter = isStepped(point) && isFiltered(*point.owner());
    if (onOwnRows || onFilter || isBetweenAwakePoints(point, partner))
      manifold.setContactProcessingThreshold(kIgnoredByBullet);
  });
}

// --- spheres against boxes ---------------------------------------------------------------------------------

void useFastSphereAlgorithms(btCollisionDispatcher& dispatcher) {
  // a dispatcher stores only pointers, and may exist until the program ends; these objects never change
  static btSphereBoxCollisionAlgorithm::CreateFunc sphereBox, boxSphere = [] {
    btSphereBoxCollisionAlgorithm::CreateFunc create;
    create.m_swapped = true;  // the second of the two objects is the sphere
    return create;
  }();
  dispatcher.registerCollisionCreateFunc(SPHERE_SHAPE_PROXYTYPE, BOX_SHAPE_PROXYTYPE, &sphereBox);
  dispatcher.registerCollisionCreateFunc(BOX_SHAPE_PROXYTYPE, SPHERE_SHAPE_PROXYTYPE, &boxSphere);
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
