// SPDX-License-Identifier: Zlib
#pragma once

#include "bullet/box_contact.h"
#include "bullet/contact_cache.h"
#include "bullet/contact_reach.h"
#include "bullet/kinematic_motion.h"
#include "bullet/surface_body.h"

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

/// The rows that one point and one partner make. Points of surfaces meet boxes as they are (nearestOnBox());
/// masses in the world meet what Bullet makes of them.
class RowsOfPair final : public btCollisionWorld::ContactResultCallback {
 public:
  RowsOfPair(SoftBodyData& body, std::uint32_t point, const btCollisionObject& partner, double reach,
             btScalar tick)
      : body_(&body),
        point_(point),
        partner_(&partner),
        reach_(reach),
        tick_(tick),
        first_(body.contacts.size()) {
    const btScalar rounding = isSurfaceBody(body) ? roundingOf(*partner.getCollisionShape()) : 0;
    m_closestDistanceThreshold = static_cast<btScalar>(reach) + rounding;
  }

  btScalar addSingleResult(btManifoldPoint& contact, const btCollisionObjectWrapper* first, int, int,
                           const btCollisionObjectWrapper* second, int, int) override {
    const bool pointIsFirst = first->getCollisionObject() == body_->masses.bodies[point_];
    const btCollisionObjectWrapper& theirs = pointIsFirst ? *second : *first;
    if (isSurfaceBody(*body_) && theirs.getCollisionShape()->getShapeType() == BOX_SHAPE_PROXYTYPE) {
      addOnBox(*static_cast<const btBoxShape*>(theirs.getCollisionShape()), theirs.getWorldTransform());
      return 0;
    }
    if (contact.getDistance() > static_cast<btScalar>(reach_)) return 0;
    const btVector3 normal = pointIsFirst ? contact.m_normalWorldOnB : -contact.m_normalWorldOnB;
    surface_ = pointIsFirst ? contact.m_positionWorldOnB : contact.m_positionWorldOnA;
    normal_ = normal;
    ++found_;
    add(toEigen(normal), surface_);
    return 0;
  }

  void addOnBox(const btBoxShape& box, const btTransform& pose) {
    const Eigen::Vector3d x = body_->state.position.col(point_);
    const NearestOnBox nearest = nearestOnBox(box, pose, x);
    const double height = nearest.normal.dot(x - nearest.surface);
    if (height - double(body_->masses.shape->getRadius()) <= reach_)
      add(nearest.normal, toBullet(nearest.surface));
  }

  /// Keeps the one contact that was found for coming ticks.
  void keepContact(CachedContact& cached, std::uint64_t stamp) const {
    const btVector3 place = toBullet(Eigen::Vector3d(body_->state.position.col(point_)));
    if (found_ == 1) limber::keepContact(cached, stamp, *partner_, surface_, normal_, place);
  }

  /// A row that the step makes follow what `around` has of this owner; up to then, it is on this plane.
  void addFollowing(HeldNeighbourhood& around, std::uint32_t owner, const HeldContact* contact) {
    ContactRow row = makeRow();
    row.around = &around;
    row.owner = owner;
    row.away = !contact;
    if (contact) row.normal = contact->normal, row.touch = contact->touch;
    push(row);
  }

  void add(const Eigen::Vector3d& normal, const btVector3& surface) {
    ContactRow row = makeRow();
    row.normal = normal.normalized();
    row.surfaceVelocity = kinematicWay(*partner_, toEigen(surface)) / double(tick_);
    row.touch = toEigen(surface) + double(body_->masses.shape->getRadius()) * row.normal;
    for (std::size_t i = first_; i < body_->contacts.size(); ++i)
      if (body_->contacts[i].normal.dot(row.normal) > kSameSurface) {
        if (gap(row) < gap(body_->contacts[i])) body_->contacts[i] = row;
        return;
      }
    push(row);
  }

 private:
  ContactRow makeRow() const {
    ContactRow row;
    row.point = point_;
    row.friction = double(gCalculateCombinedFrictionCallback(&own(), partner_));
    row.restitution = double(gCalculateCombinedRestitutionCallback(&own(), partner_));
    row.bounceThreshold = body_->speeds.bounce;
    row.recoverySpeed = body_->speeds.recovery;
    return row;
  }

  void push(const ContactRow& row) {
    body_->contacts.push_back(row);
    body_->contactPartners.push_back(partner_);
  }

  double gap(const ContactRow& row) const {
    return row.normal.dot(body_->state.position.col(point_) - row.touch);
  }

  /// What the user may have given a friction of its own.
  const btRigidBody& own() const {
    if (!body_->masses.shared) return *body_->surface.object;
    return *body_->masses.bodies[point_];
  }

  SoftBodyData* body_;
  std::uint32_t point_;
  const btCollisionObject* partner_;
  double reach_;  ///< m, beyond the radius
  btScalar tick_;
  std::size_t first_;
  int found_ = 0;
  btVector3 surface_, normal_;  // of the last one found
};

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
