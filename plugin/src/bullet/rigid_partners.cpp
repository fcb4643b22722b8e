// SPDX-License-Identifier: Zlib

// This file gathers rigid bodies for the step and writes the result so that Bullet's solver moves them as
// the step did.

#include "bullet/kinematic_motion.h"
#include "bullet/tick_contacts.h"
#include "mesh/surface.h"

#include <cmath>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {
namespace {

const btTransform& endPoseOf(const btRigidBody& body) {
  return isKinematic(body) ? body.getInterpolationWorldTransform() : body.getWorldTransform();
}

/// A held body moves at constant velocity.
RigidState movedFrom(const btTransform& start, const btTransform& end, btScalar tick) {
  RigidState state;
  state.position = toEigen(start.getOrigin());
  state.rotation = toEigen(start.getRotation());
  state.velocity = (toEigen(end.getOrigin()) - state.position) / double(tick);
  state.angularVelocity = rotationBetween(state.rotation, toEigen(end.getRotation())) / double(tick);
  return state;
}

/// It moves from its last pose to its present one. A new partner may have moved before; its world transform
/// is that at the tick's start, while kinematic bodies are Rewound.
void gatherHeldRigid(RigidPartner& partner, RigidState& state, btScalar tick) {
  const btTransform& end = endPoseOf(*partner.body);
  if (std::exchange(partner.isNew, false)) partner.lastPose = partner.body->getWorldTransform();
  state = movedFrom(partner.lastPose, end, tick);
  partner.lastPose = end;
}

/// Returns the change (rad/s) of the angular velocity that Bullet's solver makes for unequal moments of
/// inertia.
Eigen::Vector3d gyroscopicChange(const btRigidBody& body, btScalar tick) {
  if (body.getFlags() & BT_ENABLE_GYROSCOPIC_FORCE_IMPLICIT_WORLD)
    return toEigen(body.computeGyroscopicImpulseImplicit_World(tick));
  if (body.getFlags() & BT_ENABLE_GYROSCOPIC_FORCE_IMPLICIT_BODY)
    return toEigen(body.computeGyroscopicImpulseImplicit_Body(tick));
  return Eigen::Vector3d::Zero();
}

/// Returns whether the step can keep the body's angular momentum by itself. Bullet's implicit impulses lose
/// energy, the more the longer the tick.
bool isGyroscopic(const btRigidBody& body) {
  const Eigen::Vector3d inverse = toEigen(body.getInvInertiaDiagLocal());
  return (body.getFlags() & BT_ENABLE_GYROSCOPIC_FORCE_IMPLICIT_BODY ||
          body.getFlags() & BT_ENABLE_GYROSCOPIC_FORCE_IMPLICIT_WORLD) &&
         toEigen(body.getAngularFactor()) == Eigen::Vector3d::Ones() && inverse.minCoeff() > 0.0 &&
         inverse.minCoeff() < inverse.maxCoeff();
}

Eigen::Vector3d torqueAcceleration(const btRigidBody& body) {
  return toEigen(body.getInvInertiaTensorWorld() * body.getTotalTorque());
}

/// Sets the angular velocity (rad/s) at the start of the solver such that it becomes `target` before
/// impulses. Returns what it becomes, which differs for turns of a radian or more in a tick.
Eigen::Vector3d setInitialAngularVelocity(btRigidBody& body, const Eigen::Vector3d& target, btScalar tick) {
  Eigen::Vector3d initial = target;
  for (int i = 0; i < 3; ++i) {
    body.setAngularVelocity(toBullet(initial));
    initial = target - gyroscopicChange(body, tick);
  }
  body.setAngularVelocity(toBullet(initial));
  return initial + gyroscopicChange(body, tick);
}

void gatherFreeRigid(RigidPartner& partner, RigidState& state, btScalar tick) {
  const btRigidBody& body = *partner.body;
  state.position = toEigen(body.getWorldTransform().getOrigin());
  state.rotation = toEigen(body.getWorldTransform().getRotation());
  state.velocity = toEigen(body.getLinearVelocity());
  state.angularVelocity = toEigen(body.getAngularVelocity());
  state.acceleration = toEigen(body.getTotalForce()) * double(body.getInvMass());
  state.gyroscopic = isGyroscopic(body);
  state.angularAcceleration = torqueAcceleration(body);
  if (!state.gyroscopic) state.angularAcceleration += gyroscopicChange(body, tick) / double(tick);
  state.inverseMass = toEigen(body.getLinearFactor()) * double(body.getInvMass());
  state.inverseInertiaLocal = toEigen(body.getInvInertiaDiagLocal());
  state.angularFactor = toEigen(body.getAngularFactor());
}

/// Returns the factor by which Bullet multiplies velocities in the tick, before its solver. It is 0 only if
/// damping removes all motion.
double dampingFactor(btScalar damping, btScalar tick) {
  return std::pow(1.0 - double(damping), double(tick));
}

/// Bullet turns a body by no more than this in a tick, radians (btTransformUtil.h).
constexpr double kMostTurned = 0.25 * kPi;

/// Gives the body the motion of its step, and what else acted on it: fast turns are not those that Bullet
/// makes, and offsets are for Bullet's joints only. Its anchors would be torn off their points.
void completeMotion(RigidPartner& partner, btScalar tick) {
  constexpr double kSameTurn = 1e-4;  // radians
  const Eigen::Vector3d made = double(tick) * toEigen(partner.body->getAngularVelocity());
  const Eigen::Vector3d missing = partner.turn - double(tick) * toEigen(partner.expectedAngularVelocity);
  const Eigen::Vector3d turn = made + missing;
  const bool isTurned = turn.norm() < kMostTurned && missing.norm() < kSameTurn;
  if (isTurned && partner.velocityOffset.isZero(0.0)) return;
  btTransform pose = partner.body->getWorldTransform();
  pose.setOrigin(pose.getOrigin() - tick * toBullet(partner.velocityOffset));
  const Eigen::Quaterniond q = rotationBy(turn) * partner.start.rotation;
  pose.setRotation(toBullet(q));
  partner.body->setCenterOfMassTransform(pose);
}

}  // namespace

RigidPartner makePartner(btRigidBody& body) {
  RigidPartner partner;
  partner.body = &body;
  partner.handle = handleOf(body);
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
  partner.velocityOffset.setZero();
  partner.spinOffset.setZero();
}

void startFromPlace(RigidPartner& partner, RigidState& state, btScalar tick) {
  state = partner.start = movedFrom(partner.body->getWorldTransform(), endPoseOf(*partner.body), tick);
}

RigidState meanMotion(const RigidState& start, const RigidState& end, double tick) {
  RigidState mean = start;
  mean.velocity = (end.position - start.position) / tick;
  mean.angularVelocity = rotationBetween(start.rotation, end.rotation) / tick;
  return mean;
}

void writeRigidToBullet(RigidPartner& partner, const RigidState& end, btScalar tick) {
  if (partner.held) return;
  btRigidBody& body = *partner.body;
  const double h = double(tick);
  const RigidState motion = meanMotion(partner.start, end, h);
  const Eigen::Vector3d mean = motion.velocity + partner.velocityOffset;
  const Eigen::Vector3d meanAngular = motion.angularVelocity + partner.spinOffset;
  const double linear = dampingFactor(body.getLinearDamping(), tick);
  const double angular = dampingFactor(body.getAngularDamping(), tick);
  const Eigen::Vector3d initial = mean - h * partner.start.acceleration;
  const Eigen::Vector3d torque = h * torqueAcceleration(body);
  const Eigen::Vector3d reached = setInitialAngularVelocity(body, meanAngular - torque, tick) + torque;
  if (linear > 0.0) body.setLinearVelocity(toBullet(initial / linear));
  if (angular > 0.0) body.setAngularVelocity(body.getAngularVelocity() / static_cast<btScalar>(angular));
  partner.expectedVelocity = toBullet(mean);
  partner.expectedAngularVelocity = toBullet(reached);
  partner.turn = h * motion.angularVelocity;
}

void readRigidFromBullet(RigidPartner& partner, const RigidState& end, btScalar tick) {
  if (partner.held) return;
  btRigidBody& body = *partner.body;
  if (body.isActive()) completeMotion(partner, tick);
  partner.lastPose = body.getWorldTransform();
  if (!body.isActive()) return;
  const Eigen::Vector3d velocity = dampingFactor(body.getLinearDamping(), tick) * end.velocity;
  const Eigen::Vector3d spin = dampingFactor(body.getAngularDamping(), tick) * end.angularVelocity;
  body.setLinearVelocity(body.getLinearVelocity() - partner.expectedVelocity + toBullet(velocity));
  body.setAngularVelocity(body.getAngularVelocity() - partner.expectedAngularVelocity + toBullet(spin));
  body.setInterpolationLinearVelocity(body.getLinearVelocity());
  body.setInterpolationAngularVelocity(body.getAngularVelocity());
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
