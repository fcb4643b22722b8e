// SPDX-License-Identifier: Zlib

// This file finds the contacts of points with dynamic rigid bodies, and with points of other bodies.

#include "bullet/bullet_objects.h"
#include "bullet/linked_group.h"
#include "bullet/point_contacts.h"
#include "bullet/surface_body.h"
#include "bullet/tick_contacts.h"

#include <algorithm>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {
namespace {

/// Makes the contacts of one point with one rigid body.
class RigidContactCollector final : public btCollisionWorld::ContactResultCallback {
 public:
  RigidContactCollector(SoftBodyData& body, std::uint32_t point, const btRigidBody& partner,
                        double searchRegion, TickContacts& found)
      : body_(&body), point_(point), partner_(&partner), found_(&found), first_(found.contacts.size()) {
    m_closestDistanceThreshold = static_cast<btScalar>(searchRegion);
  }

  btScalar addSingleResult(btManifoldPoint& contact, const btCollisionObjectWrapper* first, int, int,
                           const btCollisionObjectWrapper*, int, int) override {
    if (contact.getDistance() > m_closestDistanceThreshold) return 0;
    const bool pointIsFirst = first->getCollisionObject() != partner_;
    const btVector3 normal = pointIsFirst ? contact.m_normalWorldOnB : -contact.m_normalWorldOnB;
    add(toEigen(normal).normalized(),
        toEigen(pointIsFirst ? contact.m_positionWorldOnB : contact.m_positionWorldOnA));
    return 0;
  }

  void add(const Eigen::Vector3d& normal, const Eigen::Vector3d& surface) {
    Contact c;
    c.a.kind = ContactPoint::Kind::Soft;
    c.a.body = body_->index;
    c.a.point[0] = point_;
    c.b = rigidContactPoint(*found_, *partner_, toBullet(surface));
    c.normal = normal;
    const double radius = double(body_->masses.shape->getRadius());
    c.gap = normal.dot(body_->state.position.col(point_) - surface) - radius;
    const btRigidBody& own = materialOf(*body_, point_);
    c.friction = double(gCalculateCombinedFrictionCallback(&own, partner_));
    c.restitution = double(gCalculateCombinedRestitutionCallback(&own, partner_));
    c.bounceThreshold = body_->speeds.bounce;
    c.recoverySpeed = body_->speeds.recovery;
    for (std::size_t i = first_; i < found_->contacts.size(); ++i)
      if (found_->contacts[i].normal.dot(normal) > kSameSurface) {
        if (c.gap < found_->contacts[i].gap) found_->contacts[i] = c;
        return;
      }
    ContactSource source;
    source.body = body_;
    source.partner = handleOf(objectInWorld(*partner_));
    source.key = point_;
    found_->add(c, source);
  }

 private:
  SoftBodyData* body_;
  std::uint32_t point_;
  const btRigidBody* partner_;
  TickContacts* found_;
  std::size_t first_;
};

/// Returns a bound (m) on the motion of the partner's surface in the tick.
double displacementInTick(const btRigidBody& partner, double tick) {
  const btScalar angularSpeed = partner.getAngularVelocity().length();
  double speed = double(partner.getLinearVelocity().length());
  if (angularSpeed > 0) speed += double(angularSpeed * partner.getCollisionShape()->getAngularMotionDisc());
  return tick * (speed + tick * double(partner.getTotalForce().length() * partner.getInvMass()));
}

void addBoxPair(RigidContactCollector& pairs, const SoftBodyData& body, std::uint32_t i,
                const btRigidBody& partner, double searchRegion) {
  const Eigen::Vector3d x = body.state.position.col(i);
  const auto& box = *static_cast<const btBoxShape*>(partner.getCollisionShape());
  const NearestOnBox nearest = nearestOnBox(box, partner.getWorldTransform(), x);
  const double height = nearest.normal.dot(x - nearest.surface);
  if (height - double(body.masses.shape->getRadius()) <= searchRegion)
    pairs.add(nearest.normal, nearest.surface);
}

void addPairs(SoftBodyData& body, std::uint32_t i, btRigidBody& partner, double tick, TickContacts& found) {
  const double motion = kSearchPerMotion * displacementInTick(partner, tick);
  const SearchRegion searchRegion = searchRegionOf(body, i, tick, motion);
  if (!overlaps(searchRegion, partner)) return;
  if (!canHit(body, i, partner)) return;
  RigidContactCollector pairs(body, i, partner, searchRegion.distance, found);
  if (partner.getCollisionShape()->getShapeType() == BOX_SHAPE_PROXYTYPE)
    return addBoxPair(pairs, body, i, partner, searchRegion.distance);
  body.world->contactPairTest(&probeAt(body, i), &partner, pairs);
}

void wake(btRigidBody& partner) {
  if (partner.isActive() || partner.getActivationState() == DISABLE_SIMULATION) return;
  partner.activate(true);
  // the world has already applied gravity to the bodies that were awake at the start of the step
  partner.applyGravity();
}

// --- points of other bodies --------------------------------------------------------------------------------

double radiusOf(const PointMass& point) { return double(point.owner()->masses.shape->getRadius()); }

/// Return the velocity (m/s) and acceleration (m/s^2) of a point; 0 for a sleeping body, which is not
/// stepped.
Eigen::Vector3d pointVelocity(const PointMass& point) {
  if (point.owner()->asleep) return Eigen::Vector3d::Zero();
  return point.owner()->state.velocity.col(point.index());
}

Eigen::Vector3d accelerationOf(const PointMass& point) {
  if (point.owner()->asleep) return Eigen::Vector3d::Zero();
  return point.owner()->state.acceleration.col(point.index());
}

ContactPoint contactPointOf(const PointMass& point) {
  ContactPoint result;
  result.kind = point.owner()->asleep ? ContactPoint::Kind::World : ContactPoint::Kind::Soft;
  result.body = point.owner()->index;
  result.point[0] = point.index();
  return result;
}

/// Makes the contacts of a point with points of other bodies.
class PointContactCollector final : public btBroadphaseAabbCallback {
 public:
  PointContactCollector(PointMass& point, double tick, TickContacts& found)
      : point_(&point), tick_(tick), found_(&found) {}

  bool process(const btBroadphaseProxy* proxy) override {
    const PointMass* other = PointMass::from(static_cast<btCollisionObject*>(proxy->m_clientObject));
    const SoftBodyData &body = *point_->owner(), *theirs = other ? other->owner() : nullptr;
    if (!theirs || theirs == &body || !theirs->alive) return true;
    // the other body adds the contact
    if (!theirs->asleep && theirs->index < body.index) return true;
    if (canHit(body, *proxy) && canHit(body, point_->index(), *other)) addIfNear(*other);
    return true;
  }

 private:
  void addIfNear(const PointMass& other) {
    const SoftBodyData& theirs = *other.owner();
    const Eigen::Vector3d offset =
        point_->owner()->state.position.col(point_->index()) - theirs.state.position.col(other.index());
    const Eigen::Vector3d velocity = pointVelocity(*point_) - pointVelocity(other);
    const double change = tick_ * tick_ * (accelerationOf(*point_) - accelerationOf(other)).norm();
    const double radiusSum = radiusOf(*point_) + radiusOf(other);
    if (offset.norm() - radiusSum > kSearchPerMotion * (tick_ * velocity.norm() + change) + radiusSum / 3.0)
      return;
    const Eigen::Vector3d nearest = offsetWhenNearest(offset, velocity, tick_, radiusSum);
    if (nearest.norm() > 0.0) add(other, nearest.normalized(), offset, radiusSum);
  }

  void add(const PointMass& other, const Eigen::Vector3d& normal, const Eigen::Vector3d& offset,
           double radiusSum) {
    SoftBodyData &body = *point_->owner(), &theirs = *other.owner();
    Contact c;
    c.a = contactPointOf(*point_);
    c.b = contactPointOf(other);
    c.normal = normal;
    c.gap = normal.dot(offset) - radiusSum;
    c.spheres = theirs.asleep ? 0.0 : radiusSum;
    c.friction = double(gCalculateCombinedFrictionCallback(point_, &other));
    c.restitution = double(gCalculateCombinedRestitutionCallback(point_, &other));
    c.bounceThreshold = body.speeds.bounce;
    c.recoverySpeed =
        theirs.asleep ? body.speeds.recovery : std::min(body.speeds.recovery, theirs.speeds.recovery);
    ContactSource source;
    source.body = &body;
    source.other = &theirs;
    source.partner = handleOf(other);
    source.key = point_->index();
    found_->add(c, source);
  }

  PointMass* point_;
  double tick_;
  TickContacts* found_;
};

struct OtherPointsQuery final : btBroadphaseAabbCallback {
  explicit OtherPointsQuery(const SoftBodyData& b) : body(&b) {}
  const SoftBodyData* body;
  bool any = false;

  bool process(const btBroadphaseProxy* proxy) override {
    const PointMass* point = PointMass::from(static_cast<btCollisionObject*>(proxy->m_clientObject));
    any = any || (point && point->owner() != body);
    return true;
  }
};

void findAround(SoftBodyData& body, const Eigen::Vector3d& low, const Eigen::Vector3d& high,
                btBroadphaseAabbCallback& callback) {
  body.world->getBroadphase()->aabbTest(toBullet(low), toBullet(high), callback);
}

void addPointPairs(SoftBodyData& body, double tick, double farthest, TickContacts& found) {
  Eigen::AlignedBox3d box;
  for (std::uint32_t i = 0; i < body.masses.bodies.size(); ++i) {
    const SearchRegion searchRegion = searchRegionOf(body, i, tick, farthest);
    box.extend(searchRegion.low).extend(searchRegion.high);
  }
  OtherPointsQuery others(body);
  findAround(body, box.min(), box.max(), others);
  if (!others.any) return;
  for (std::uint32_t i = 0; i < body.masses.bodies.size(); ++i) {
    const SearchRegion searchRegion = searchRegionOf(body, i, tick, farthest);
    PointContactCollector pairs(*body.masses.bodies[i], tick, found);
    findAround(body, searchRegion.low, searchRegion.high, pairs);
  }
}

}  // namespace

void gatherPairs(SoftBodyData& body, btRigidBody& partner, btScalar tick, TickContacts& found) {
  wake(partner);
  for (std::uint32_t i = 0; i < pointCount(body); ++i) addPairs(body, i, partner, double(tick), found);
}

void gatherPointPairs(const AwakeGroups& groups, btScalar tick, TickContacts& found) {
  // no point moves farther than this towards another one
  double farthest = 0.0;
  for (const LinkedGroup* group : groups)
    for (const SoftBodyData* body : group->bodies)
      if (!isSurfaceBody(*body))
        farthest =
            std::max(farthest, *std::max_element(body->searchDistance.begin(), body->searchDistance.end()));
  for (const LinkedGroup* group : groups)
    for (SoftBodyData* body : group->bodies)
      if (!isSurfaceBody(*body)) addPointPairs(*body, double(tick), farthest, found);
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
