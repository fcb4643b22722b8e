// SPDX-License-Identifier: Zlib
#pragma once

#include "bullet/soft_body_data.h"

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

// To its user the surface object is a rigid body with the mass, inertia and mean motion of the body's points
// that are not held. Whatever differs from what was last left in it is the user's doing, or that of a
// constraint in Bullet's solver, and moves all points as it would move a rigid body.

/// Leaves in the object where and how the body is now. Its basis turns with the body.
void writeObject(SoftBodyData& body);

/// Whether the user has moved the object or changed its velocity.
bool isObjectChanged(const SoftBodyData& body);

/// Gives the points what differs in the object. `drift` (s): for so long they have moved with the change of
/// velocity.
void readObject(SoftBodyData& body, double drift = 0.0);

/// At the start of a tick: adds the forces on the object, which act in all ticks of a stepSimulation(), to the
/// points' accelerations. What acts on one that sleeps is lost, as with Bullet's bodies.
void accelerateByObject(SoftBodyData& body);
void dropObjectForces(SoftBodyData& body);

/// Marks the bodies that Bullet's constraints hold by their objects (SurfaceData::joined).
void markJoined(const std::vector<SoftBodyData*>& bodies, btDiscreteDynamicsWorld& world);

/// Before Bullet's solver: an object in a constraint has the mean velocity of the tick.
void handOverObject(SoftBodyData& body, double tick);

/// After it: what the constraint gave has acted from the start of the tick on. It pushes no point into what
/// its contacts keep it out of.
void takeBackObject(SoftBodyData& body, double tick);

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
