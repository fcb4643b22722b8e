// SPDX-License-Identifier: Zlib
#include "bullet/rigid_partner.h"

#include "bullet/bullet_objects.h"
#include "bullet/kinematic_motion.h"

#include <cmath>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {
namespace {

void gatherHeldRigid(RigidPartner& partner, RigidState& state, btScalar tick) {
  const btRigidBody& body = *partner.body;
  const btTransform& pose =
      isKinematic(body) ? body.getInterpolationWorldTransform() : body.getWorldTransform();
  state = RigidState();
  state.position = toEigen(partner.lastPose.getOrigin());
  state.rotation = toEigen(partner.lastPose.getRotation());
  state.velocity = (toEigen(pose.getOrigin()) - state.position) / double(tick);
  state.angularVelocity = rotationBetween(state.rotation, toEigen(pose.getRotation())) / double(tick);
  partner.lastPose = pose;
}

/// rad/s, by what Bullet's solver changes the body's angular velocity for its unequal moments of inertia.
Eigen::Vector3d gyroscopicChange(const btRigidBody& body, btScalar tick) {
  if (body.getFlags() & BT_ENABLE_GYROSCOPIC_FORCE_IMPLICIT_WORLD)
    return toEigen(body.computeGyroscopicImpulseImplicit_World(tick));
  if (body.getFlags() & BT_ENABLE_GYROSCOPIC_FORCE_IMPLICIT_BODY)
    return toEigen(body.computeGyroscopicImpulseImplicit_Body(tick));
  return Eigen::Vector3d::Zero();
}

Eigen::Vector3d turnByTorque(const btRigidBody& body) {
  return toEigen(body.getInvInertiaTensorWorld() * body.getTotalTorque());
}

/// Sets the angular velocity (rad/s) with which the solver begins so that it will be `wanted` before impulses.
void setTurnBeforeSolver(btRigidBody& body, const Eigen::Vector3d& wanted, btScalar tick) {
  Eigen::Vector3d handed = wanted;
  for (int i = 0; i < 3; ++i) {
    body.setAngularVelocity(toBullet(handed));
    handed = wanted - gyroscopicChange(body, tick);
  }
  body.setAngularVelocity(toBullet(handed));
}

void gatherFreeRigid(RigidPartner& partner, RigidState& state, btScalar tick) {
  const btRigidBody& body = *partner.body;
  state.position = toEigen(body.getWorldTransform().getOrigin());
  state.rotation = toEigen(body.getWorldTransform().getRotation());
  state.velocity = toEigen(body.getLinearVelocity());
  state.angularVelocity = toEigen(body.getAngularVelocity());
  state.acceleration = toEigen(body.getTotalForce()) * double(body.getInvMass());
  state.angularAcceleration = turnByTorque(body) + gyroscopicChange(body, tick) / double(tick);
  state.inverseMass = toEigen(body.getLinearFactor()) * double(body.getInvMass());
  state.inverseInertiaLocal = toEigen(body.getInvInertiaDiagLocal());
  state.angularFactor = toEigen(body.getAngularFactor());
}

/// What Bullet multiplies velocities by in the tick, before its solver; it is 0 only where all motion is
/// lost.
double keptShare(btScalar damping, btScalar tick) { return std::pow(1.0 - double(damping), double(tick)); }

}  // namespace

RigidPartner makePartner(btRigidBody& body) {
  RigidPartner partner;
  partner.body = &body;
  partner.mark = markOf(body);
  partner.lastPose = body.getWorldTransform();
  return partner;
}

void gatherRigid(RigidPartner& partner, RigidState& state, btScalar tick) {
  partner.held =
      isStaticOrKinematic(*partner.body) || partner.body->getActivationState() == DISABLE_SIMULATION;
  if (partner.held)
    gatherHeldRigid(partner, state, tick);
  else
    gatherFreeRigid(partner, state, tick);
  partner.start = state;
}

void handOverRigid(RigidPartner& partner, const RigidState& end, btScalar tick) {
  if (partner.held) return;
  btRigidBody& body = *partner.body;
  const double h = double(tick);
  const Eigen::Vector3d mean = (end.position - partner.start.position) / h;
  const Eigen::Vector3d meanAngular = rotationBetween(partner.start.rotation, end.rotation) / h;
  const double linear = keptShare(body.getLinearDamping(), tick);
  const double angular = keptShare(body.getAngularDamping(), tick);
  const Eigen::Vector3d handed = mean - h * partner.start.acceleration;
  setTurnBeforeSolver(body, meanAngular - h * turnByTorque(body), tick);
  if (linear > 0.0) body.setLinearVelocity(toBullet(Eigen::Vector3d(handed / linear)));
  if (angular > 0.0) body.setAngularVelocity(body.getAngularVelocity() / static_cast<btScalar>(angular));
  partner.expectedVelocity = toBullet(mean);
  partner.expectedAngularVelocity = toBullet(meanAngular);
}

void pushLater(RigidPartner& partner, const Eigen::Vector3d& impulse, const Eigen::Vector3d& turn, btScalar tick) {
  if (partner.held) return;
  btRigidBody& body = *partner.body;
  const double linear = keptShare(body.getLinearDamping(), tick);
  const double angular = keptShare(body.getAngularDamping(), tick);
  const btVector3 velocity = toBullet(impulse) * body.getInvMass() * body.getLinearFactor();
  const btVector3 spin = body.getInvInertiaTensorWorld() * toBullet(turn) * body.getAngularFactor();
  if (linear > 0.0) body.setLinearVelocity(body.getLinearVelocity() - velocity / static_cast<btScalar>(linear));
  if (angular > 0.0) body.setAngularVelocity(body.getAngularVelocity() - spin / static_cast<btScalar>(angular));
}

void takeBackRigid(RigidPartner& partner, const RigidState& end, btScalar tick) {
  if (partner.held || !partner.body->isActive()) return;
  btRigidBody& body = *partner.body;
  const Eigen::Vector3d velocity = keptShare(body.getLinearDamping(), tick) * end.velocity;
  const Eigen::Vector3d spin = keptShare(body.getAngularDamping(), tick) * end.angularVelocity;
  body.setLinearVelocity(body.getLinearVelocity() - partner.expectedVelocity + toBullet(velocity));
  body.setAngularVelocity(body.getAngularVelocity() - partner.expectedAngularVelocity + toBullet(spin));
  body.setInterpolationLinearVelocity(body.getLinearVelocity());
  body.setInterpolationAngularVelocity(body.getAngularVelocity());
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
