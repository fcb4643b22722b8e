// SPDX-License-Identifier: Zlib
#pragma once

#include "bullet/bullet_objects.h"
#include "core/rigid_state.h"

#include <limber/bullet_precision.h>

#include <btBulletDynamicsCommon.h>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

/// A rigid body of the user's that springs or anchors hold on to: it takes part in the substeps and, like a
/// point mass, is handed its mean velocity of the tick.
struct RigidPartner {
  btRigidBody* body = nullptr;
  bool held = false;           ///< static, kinematic or out of the simulation: it moves as told
  PartnerMark mark;            ///< of the body
  btTransform lastPose;        ///< of a held body at the end of the last tick
  RigidState start;            ///< at the start of the tick
  btVector3 expectedVelocity;  ///< after the tick if nothing else acts
  btVector3 expectedAngularVelocity;
};

/// The body must be in the world.
RigidPartner makePartner(btRigidBody& body);

/// Fills `state` from Bullet's body. A held body moves evenly from its last pose to its present one.
void gatherRigid(RigidPartner& partner, RigidState& state, btScalar tick);

/// As handOverVelocities() and takeBackContacts() for point masses. Bullet's damping acts on both the
/// velocity handed over, where it is made up for, and the one at the end.
void handOverRigid(RigidPartner& partner, const RigidState& end, btScalar tick);
/// Takes off what is handed over what an impulse (N s) and one that turns (N m s) will give back in Bullet's solver.
void pushLater(RigidPartner& partner, const Eigen::Vector3d& impulse, const Eigen::Vector3d& turn, btScalar tick);
void takeBackRigid(RigidPartner& partner, const RigidState& end, btScalar tick);

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
