// SPDX-License-Identifier: Zlib
#include "bullet/rigid_partner.h"

#include "bullet/convert.h"

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {
namespace {

void gatherHeldRigid(RigidPartner& partner, RigidState& state, btScalar tick) {
  const btTransform& pose = partner.body->getWorldTransform();
  state = RigidState();
  state.position = toEigen(partner.lastPose.getOrigin());
  state.rotation = toEigen(partner.lastPose.getRotation());
  state.velocity = (toEigen(pose.getOrigin()) - state.position) / double(tick);
  state.angularVelocity = rotationBetween(state.rotation, toEigen(pose.getRotation())) / double(tick);
  partner.lastPose = pose;
}

void gatherFreeRigid(RigidPartner& partner, RigidState& state) {
  const btRigidBody& body = *partner.body;
  state.position = toEigen(body.getWorldTransform().getOrigin());
  state.rotation = toEigen(body.getWorldTransform().getRotation());
  state.velocity = toEigen(body.getLinearVelocity());
  state.angularVelocity = toEigen(body.getAngularVelocity());
  state.acceleration = toEigen(body.getTotalForce()) * double(body.getInvMass());
  state.angularAcceleration = toEigen(body.getInvInertiaTensorWorld() * body.getTotalTorque());
  state.inverseMass = toEigen(body.getLinearFactor()) * double(body.getInvMass());
  state.inverseInertiaLocal = toEigen(body.getInvInertiaDiagLocal());
  state.angularFactor = toEigen(body.getAngularFactor());
}

}  // namespace

RigidPartner makePartner(btRigidBody& body) {
  RigidPartner partner;
  partner.body = &body;
  partner.lastPose = body.getWorldTransform();
  return partner;
}

void gatherRigid(RigidPartner& partner, RigidState& state, btScalar tick) {
  partner.held =
      partner.body->isStaticOrKinematicObject() || partner.body->getActivationState() == DISABLE_SIMULATION;
  if (partner.held)
    gatherHeldRigid(partner, state, tick);
  else
    gatherFreeRigid(partner, state);
  partner.start = state;
}

void handOverRigid(RigidPartner& partner, const RigidState& end, btScalar tick) {
  if (partner.held) return;
  btRigidBody& body = *partner.body;
  const double h = double(tick);
  const Eigen::Vector3d mean = (end.position - partner.start.position) / h;
  const Eigen::Vector3d meanAngular = rotationBetween(partner.start.rotation, end.rotation) / h;
  body.setLinearVelocity(toBullet(Eigen::Vector3d(mean - h * partner.start.acceleration)));
  body.setAngularVelocity(toBullet(Eigen::Vector3d(meanAngular - h * partner.start.angularAcceleration)));
  partner.expectedVelocity = toBullet(mean);
  partner.expectedAngularVelocity = toBullet(meanAngular);
}

void takeBackRigid(RigidPartner& partner, const RigidState& end) {
  if (partner.held || !partner.body->isActive()) return;
  btRigidBody& body = *partner.body;
  body.setLinearVelocity(body.getLinearVelocity() - partner.expectedVelocity + toBullet(end.velocity));
  body.setAngularVelocity(body.getAngularVelocity() - partner.expectedAngularVelocity +
                          toBullet(end.angularVelocity));
  body.setInterpolationLinearVelocity(body.getLinearVelocity());
  body.setInterpolationAngularVelocity(body.getAngularVelocity());
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
