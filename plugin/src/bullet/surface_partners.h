// SPDX-License-Identifier: Zlib
#pragma once

#include "bullet/kinematic_motion.h"
#include "bullet/soft_body_data.h"

#include <Eigen/Geometry>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

/// The surface of a living body of `system`, or nullptr.
SurfaceObject* livingSurface(const btBroadphaseProxy* proxy, const void* system);

/// Whether contacts with this partner, which Bullet's broadphase pairs with it, wake a surface or point.
bool mayWake(const btRigidBody& own, const btCollisionObject& partner);

/// Adds a partner of the coming tick, met by the body's surface or point `own`. A body that sleeps is woken by
/// kinematic objects that are awake, as Bullet's islands do.
void meetPartner(SoftBodyData& body, btRigidBody& own, btCollisionObject& partner);

/// Before a tick: gives every awake surface body of `system` the static and kinematic objects that Bullet's
/// broadphase found near it (surface.partners, in order of their unique ids), and wakes those that sleep
/// where a kinematic object is awake, as Bullet's islands do.
/// One pass over the pairs instead of one query per body.
void collectPartners(btDiscreteDynamicsWorld& world, const void* system);

/// Adds to them, and to those of bodies with Collision::Points, the objects of the user's that will get near in
/// the coming tick because of their own motion, of which the broadphase does not know yet, and wakes bodies
/// that sleep in their way. Dynamic bodies are looked for by surfaces only: points leave them to Bullet.
void collectMovers(btDiscreteDynamicsWorld& world, const KinematicMotions& kinematic, const void* system,
                   btScalar tick);

/// Whether surface.partners holds everything that may touch something in this box (m) in the coming tick:
/// Bullet's broadphase has looked there.
bool partnersCover(const SoftBodyData& body, const Eigen::AlignedBox3d& box);

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
