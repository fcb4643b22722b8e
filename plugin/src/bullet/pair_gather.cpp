// SPDX-License-Identifier: Zlib
#include "bullet/pair_gather.h"

#include "bullet/box_contact.h"
#include "bullet/contact_filter.h"
#include "bullet/contact_reach.h"
#include "bullet/convert.h"
#include "bullet/multibody_links.h"

#include <algorithm>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {
namespace {

/// The contacts that one point and one rigid body make.
class PairsOfPoint final : public btCollisionWorld::ContactResultCallback {
 public:
  PairsOfPoint(SoftBodyData& body, std::uint32_t point, const btRigidBody& partner, double reach,
               TickContacts& found)
      : body_(&body), point_(point), partner_(&partner), found_(&found), first_(found.contacts.size()) {
    m_closestDistanceThreshold = static_cast<btScalar>(reach);
  }

  btScalar addSingleResult(btManifoldPoint& contact, const btCollisionObjectWrapper* first, int, int,
                           const btCollisionObjectWrapper*, int, int) override {
    if (contact.getDistance() > m_closestDistanceThreshold) return 0;
    const bool pointIsFirst = first->getCollisionObject() == body_->masses.bodies[point_];
    const btVector3 normal = pointIsFirst ? contact.m_normalWorldOnB : -contact.m_normalWorldOnB;
    add(toEigen(normal).normalized(),
        toEigen(pointIsFirst ? contact.m_positionWorldOnB : contact.m_positionWorldOnA));
    return 0;
  }

  void add(const Eigen::Vector3d& normal, const Eigen::Vector3d& surface) {
    PairContact c;
    c.a.kind = ContactPlace::Kind::Soft;
    c.a.body = body_->index;
    c.a.point[0] = point_;
    c.b = placeOn(*found_, *partner_, toBullet(surface));
    c.normal = normal;
    const double radius = double(body_->masses.shape->getRadius());
    c.gap = normal.dot(body_->state.position.col(point_) - surface) - radius;
    const PointMass* point = body_->masses.bodies[point_];
    c.friction = double(gCalculateCombinedFrictionCallback(point, partner_));
    c.restitution = double(gCalculateCombinedRestitutionCallback(point, partner_));
    c.bounceThreshold = body_->speeds.bounce;
    c.recoverySpeed = body_->speeds.recovery;
    for (std::size_t i = first_; i < found_->contacts.size(); ++i)
      if (found_->contacts[i].normal.dot(normal) > kSameSurface) {
        if (c.gap < found_->contacts[i].gap) found_->contacts[i] = c;
        return;
      }
    ContactSource source;
    source.body = body_;
    source.partner = markOf(objectInWorld(*partner_));
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

/// m, how far the partner's surface may move in the tick.
double wayInTick(const btRigidBody& partner, double tick) {
  const btScalar turn = partner.getAngularVelocity().length();
  double speed = double(partner.getLinearVelocity().length());
  if (turn > 0) speed += double(turn * partner.getCollisionShape()->getAngularMotionDisc());
  return tick * (speed + tick * double(partner.getTotalForce().length() * partner.getInvMass()));
}

void addBoxPair(PairsOfPoint& pairs, const SoftBodyData& body, std::uint32_t i, const btRigidBody& partner,
                double reach) {
  const Eigen::Vector3d x = body.state.position.col(i);
  const auto& box = *static_cast<const btBoxShape*>(partner.getCollisionShape());
  const NearestOnBox nearest = nearestOnBox(box, partner.getWorldTransform(), x);
  const double height = nearest.normal.dot(x - nearest.surface);
  if (height - double(body.masses.shape->getRadius()) <= reach) pairs.add(nearest.normal, nearest.surface);
}

void addPairs(SoftBodyData& body, std::uint32_t i, btRigidBody& partner, double tick, TickContacts& found) {
  const double motion = kReachPerMotion * wayInTick(partner, tick);
  const Reach reach = reachOf(body, i, tick, motion);
  if (!overlaps(reach, partner)) return;
  PointMass& point = *body.masses.bodies[i];
  if (!canHit(body, point, partner)) return;
  PairsOfPoint pairs(body, i, partner, reach.distance, found);
  if (partner.getCollisionShape()->getShapeType() == BOX_SHAPE_PROXYTYPE)
    return addBoxPair(pairs, body, i, partner, reach.distance);
  if (!body.masses.shared) writePoint(body, i);
  body.world->contactPairTest(&point, &partner, pairs);
}

void wake(btRigidBody& partner) {
  if (partner.isActive() || partner.getActivationState() == DISABLE_SIMULATION) return;
  partner.activate(true);
  // the world has already given gravity to those that were awake at the start of the step
  partner.applyGravity();
}

}  // namespace

void gatherPairs(SoftBodyData& body, btRigidBody& partner, btScalar tick, TickContacts& found) {
  wake(partner);
  for (std::uint32_t i = 0; i < body.masses.bodies.size(); ++i)
    addPairs(body, i, partner, double(tick), found);
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
