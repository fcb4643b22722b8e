// SPDX-License-Identifier: Zlib

// This header declares the rigid bodies that soft bodies touch or that are attached to them: between read and
// write of a tick the step moves them, not Bullet. "Held" means static, kinematic or out of the simulation.

#pragma once

#include "bullet/bullet_objects.h"
#include "solver/links.h"

#include <limber/bullet_precision.h>

#include <btBulletDynamicsCommon.h>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

/// A rigid body of the user in a link or contact with soft bodies. It is stepped in the substeps. Like a
/// point mass, it then gets its mean velocity in the tick.
struct RigidPartner {
  btRigidBody* body = nullptr;
  bool held = false;     ///< static, kinematic or out of the simulation
  ObjectHandle handle;   ///< of the body
  bool isNew = true;     ///< not yet in a tick
  btTransform lastPose;  ///< at the end of the last tick
  RigidState start;      ///< at the start of the tick
  Eigen::Vector3d velocityOffset = Eigen::Vector3d::Zero(),
                  spinOffset = Eigen::Vector3d::Zero();  ///< m/s and rad/s, added to what Bullet gets: see
                                                         ///< offerToJoints()
  btVector3 expectedVelocity;                            ///< after the tick if nothing else acts
  btVector3 expectedAngularVelocity;
  Eigen::Vector3d turn;  ///< radians, of the tick if nothing else acts
};

/// The body must be in the world.
RigidPartner makePartner(btRigidBody& body);

/// Fills `state` from Bullet's body.
void gatherRigid(RigidPartner& partner, RigidState& state, btScalar tick);

/// Makes a held body, while kinematic ones are Rewound, start where it was placed instead of at its last
/// pose.
void startFromPlace(RigidPartner& partner, RigidState& state, btScalar tick);

/// Returns the mean velocities (m/s, rad/s) of a body in the tick, at its place at the start.
RigidState meanMotion(const RigidState& start, const RigidState& end, double tick);

/// Like writeVelocitiesToBullet() and finishWorldPoints() for point masses. Bullet's damping acts on the
/// written velocity, where it is compensated, and on the velocity at the end.
void writeRigidToBullet(RigidPartner& partner, const RigidState& end, btScalar tick);
void readRigidFromBullet(RigidPartner& partner, const RigidState& end, btScalar tick);

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
