// SPDX-License-Identifier: Zlib

// This file makes rigid bodies and joints from the links of multibodies for a tick, and applies the resulting
// impulses to the multibodies.

#include "bullet/bullet_objects.h"
#include "bullet/tick_contacts.h"
#include "mesh/linear_algebra.h"

#include <algorithm>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {
namespace {

using Eigen::Vector3d;
using Vector6d = Eigen::Matrix<double, 6, 1>;

/// Number of ticks after which a body that has no soft body near it is removed.
constexpr int kMaxUnusedTicks = 120;

btTransform poseOf(const btMultiBody& m, int link) {
  if (link < 0) return btTransform(m.getWorldToBaseRot().inverse(), m.getBasePos());
  return btTransform(m.localFrameToWorld(link, btMatrix3x3::getIdentity()),
                     m.localPosToWorld(link, btVector3(0, 0, 0)));
}

/// Sets the pose and velocity of a link from the multibody's own state, because its collider is updated only
/// after each tick.
void placeLink(LinkBody& body, const btVector3& velocity, const btVector3& spin) {
  const btMultiBody& m = *body.multiBody;
  const bool isBase = body.link < 0;
  const btTransform pose = poseOf(m, body.link);
  body.setMassProps(isBase ? m.getBaseMass() : m.getLinkMass(body.link),
                    isBase ? m.getBaseInertia() : m.getLinkInertia(body.link));
  body.setWorldTransform(pose);
  body.setInterpolationWorldTransform(pose);
  body.updateInertiaTensor();
  body.setLinearVelocity(pose.getBasis() * velocity);
  body.setAngularVelocity(pose.getBasis() * spin);
  body.clearForces();
  // the force includes gravity
  body.applyCentralForce(isBase ? m.getBaseForce() : m.getLinkForce(body.link));
  body.applyTorque(isBase ? m.getBaseTorque() : m.getLinkTorque(body.link));
  body.impulse = body.angularImpulse = btVector3(0, 0, 0);
}

/// Returns the directions in which a joint lets its link move: its angular velocity and, below, the velocity
/// of the link's centre of mass, in the link's frame.
Eigen::MatrixXd freedomOf(const btMultibodyLink& link) {
  Eigen::MatrixXd freedom(6, link.m_dofCount);
  for (int d = 0; d < link.m_dofCount; ++d) {
    freedom.block<3, 1>(0, d) = toEigen(link.getAxisTop(d));
    freedom.block<3, 1>(3, d) = toEigen(link.getAxisBottom(d));
  }
  return freedom;
}

}  // namespace

bool isHeldLink(const btMultiBodyLinkCollider& collider) {
  const btMultiBody& m = *collider.m_multiBody;
  for (int link = collider.m_link; link >= 0; link = m.getLink(link).m_parent)
    if (m.getLink(link).m_dofCount > 0) return false;
  return m.hasFixedBase();
}

void MultiBodyLinks::begin(const btCollisionWorld& world) {
  objects_ = world.getNumCollisionObjects();
  touched_.clear();
  const auto isOld = [](const auto& body) { return ++body->unused > kMaxUnusedTicks; };
  bodies_.erase(std::remove_if(bodies_.begin(), bodies_.end(), isOld), bodies_.end());
}

LinkBody& MultiBodyLinks::bodyOf(btMultiBody& multiBody, int link) {
  const auto isThis = [&](const auto& b) { return b->multiBody == &multiBody && b->link == link; };
  auto it = std::find_if(bodies_.begin(), bodies_.end(), isThis);
  if (it == bodies_.end()) it = bodies_.insert(it, std::make_unique<LinkBody>(multiBody, link));
  LinkBody& body = **it;
  if (body.unused == 0) return body;
  body.unused = 0;
  body.collider = nullptr;
  body.setCollisionShape(&none_);
  // after all objects of the world
  body.setWorldArrayIndex(objects_ + static_cast<int>(it - bodies_.begin()));
  spins_.resize(multiBody.getNumLinks() + 1);
  velocities_.resize(multiBody.getNumLinks() + 1);
  multiBody.compTreeLinkVelocities(&spins_[0], &velocities_[0]);
  placeLink(body, velocities_[link + 1], spins_[link + 1]);
  return body;
}

LinkBody& MultiBodyLinks::bodyOf(const btMultiBodyLinkCollider& collider) {
  LinkBody& body = bodyOf(*collider.m_multiBody, collider.m_link);
  if (body.collider == &collider) return body;
  body.collider = &collider;
  auto& object = const_cast<btMultiBodyLinkCollider&>(collider);
  body.setCollisionShape(object.getCollisionShape());
  body.setBroadphaseHandle(object.getBroadphaseHandle());
  body.setWorldArrayIndex(object.getWorldArrayIndex());
  body.setFriction(object.getFriction());
  body.setRestitution(object.getRestitution());
  body.forceActivationState(object.getActivationState());
  return body;
}

void MultiBodyLinks::addJoint(btMultiBody& multiBody, int link, TickContacts& found) {
  const btMultibodyLink& joint = multiBody.getLink(link);
  LinkBody& child = bodyOf(multiBody, link);
  LinkBody& parent = bodyOf(multiBody, joint.m_parent);
  const auto numberOf = [&](LinkBody& body) {
    const bool fixed = body.link < 0 && multiBody.hasFixedBase();
    return fixed || !isFree(body) ? JointConstraint::kHeld : found.add(body);
  };
  const Vector3d arm = toEigen(child.getCenterOfMassPosition()) - toEigen(parent.getCenterOfMassPosition());
  const btMatrix3x3& basis = child.getWorldTransform().getBasis();
  const std::uint32_t a = numberOf(child), b = numberOf(parent);
  if (a == JointConstraint::kHeld && b == JointConstraint::kHeld) return;
  // all directions except those of the joint's freedom
  const Eigen::MatrixXd freedom = freedomOf(joint);
  const Eigen::Matrix<double, 6, 6> directions = orthogonalColumns(freedom, 6);
  for (Eigen::Index d = freedom.cols(); d < 6; ++d) {
    const Vector6d fixedDirection = directions.col(d);
    JointConstraint row;
    row.a = a, row.b = b;
    row.angularA = toEigen(basis * toBullet(fixedDirection.head<3>()));
    row.linearA = toEigen(basis * toBullet(fixedDirection.tail<3>()));
    row.linearB = -row.linearA;
    row.angularB = -row.angularA - arm.cross(row.linearA);
    row.armB = arm;
    found.joints.push_back(row);
    found.jointSources.emplace_back();
  }
}

void MultiBodyLinks::addJoints(btMultiBody& multiBody, btCollisionObject& touched, TickContacts& found) {
  for (int link = -1; link < multiBody.getNumLinks(); ++link) {
    LinkBody& body = bodyOf(multiBody, link);
    if (body.collider) continue;
    body.setBroadphaseHandle(touched.getBroadphaseHandle());
    body.forceActivationState(touched.getActivationState());
  }
  for (int link = 0; link < multiBody.getNumLinks(); ++link) addJoint(multiBody, link, found);
}

void MultiBodyLinks::addJoints(TickContacts& found) {
  const std::size_t count = found.rigids.size();
  for (std::size_t i = 0; i < count; ++i) {
    const LinkBody* body = LinkBody::from(found.rigids[i].body);
    if (!body || std::find(touched_.begin(), touched_.end(), body->multiBody) != touched_.end()) continue;
    touched_.push_back(body->multiBody);
    addJoints(*body->multiBody, *found.rigids[i].body, found);
  }
}

void MultiBodyLinks::applyImpulses(const TickContacts& found) {
  if (touched_.empty()) return;
  for (const Contact& c : found.contacts)
    for (const ContactPoint* point : {&c.a, &c.b}) {
      if (point->kind != ContactPoint::Kind::Rigid) continue;
      LinkBody* body = LinkBody::from(found.rigids[point->body].body);
      if (!body) continue;
      const Vector3d impulse = point == &c.a ? c.impulse.sum : Vector3d(-c.impulse.sum);
      body->impulse += toBullet(impulse);
      body->angularImpulse += toBullet(point->arm.cross(impulse));
    }
  for (btMultiBody* multiBody : touched_) apply(*multiBody);
}

void MultiBodyLinks::apply(btMultiBody& multiBody) {
  const int size = multiBody.getNumDofs() + 6;
  force_.resize(size), change_.resize(size), jacobian_.resize(size);
  for (int i = 0; i < size; ++i) force_[i] = 0;
  bool any = false;
  for (const auto& body : bodies_) {
    if (body->multiBody != &multiBody || body->unused > 0) continue;
    if (body->impulse.isZero() && body->angularImpulse.isZero()) continue;
    any = true;
    multiBody.fillConstraintJacobianMultiDof(body->link, poseOf(multiBody, body->link).getOrigin(),
                                             body->angularImpulse, body->impulse, &jacobian_[0], numbers_,
                                             vectors_, matrices_);
    for (int i = 0; i < size; ++i) force_[i] += jacobian_[i];
  }
  if (!any) return;
  // with a time step of 0 this keeps the velocities, and computes the inertias for the next call
  multiBody.computeAccelerationsArticulatedBodyAlgorithmMultiDof(btScalar(0), numbers_, vectors_, matrices_,
                                                                 false, false, false);
  multiBody.calcAccelerationDeltasMultiDof(&force_[0], &change_[0], numbers_, vectors_);
  multiBody.applyDeltaVeeMultiDof(&change_[0], btScalar(1));
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
