// SPDX-License-Identifier: Zlib
#pragma once

#include "bullet/soft_body_data.h"

#include <Eigen/Geometry>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

/// The surface of a living body of `system`, or nullptr.
SurfaceObject* livingSurface(const btBroadphaseProxy* proxy, const void* system);

/// Adds a partner of the coming tick. A body that sleeps is woken by kinematic objects that are awake, as
/// Bullet's islands do.
void meetPartner(SurfaceObject& surface, btCollisionObject& partner);

/// Before a tick: gives every awake surface body of `system` the static and kinematic objects that Bullet's
/// broadphase found near it (surface.partners, in order of their unique ids), and wakes those that sleep
/// where a kinematic object is awake, as Bullet's islands do.
/// One pass over the pairs instead of one query per body.
void collectPartners(btDiscreteDynamicsWorld& world, const void* system);

/// Adds to them the rigid bodies of the user's that will get near in the coming tick because of their own
/// motion, of which the broadphase does not know yet, and wakes surface bodies that sleep in their way.
void collectMovers(btDiscreteDynamicsWorld& world, const void* system, btScalar tick);

/// Whether surface.partners holds everything that may touch something in this box (m) in the coming tick:
/// Bullet's broadphase has looked there.
bool partnersCover(const SoftBodyData& body, const Eigen::AlignedBox3d& box);

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
