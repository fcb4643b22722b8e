// SPDX-License-Identifier: Zlib
#pragma once

#include "bullet/soft_body_data.h"

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

// How a body with Collision::Points lives in the world: each point mass is an ordinary sphere body, which
// Bullet moves and whose contacts with dynamic bodies Bullet solves.

/// Makes the point masses and adds them to the world.
void addPointMasses(SoftBodyData& body);

/// Removes and deletes those that the application has not deleted. A world that is gone is not touched.
void removePointMasses(SoftBodyData& body);

/// gatherPoints(), and the accelerations from Bullet's total forces (gravity included).
void gatherWorldPoints(SoftBodyData& body, btScalar tick);

/// After the step: gives each body the mean velocity of the tick without the part that Bullet adds itself,
///     u = (x_end - x_start) / h - a h,
/// so that Bullet's own integration x += h (u + a h) ends where the step ended.
void handOverVelocities(SoftBodyData& body, btScalar tick);

/// After Bullet's contacts: whatever it changed of the velocity it was expected to leave is an impulse,
///     v = v_end + D,  x = x_end + h D,  D = v_bullet - v_expected,
/// plus any displacement that no velocity explains (split impulse, continuous collision).
/// Then continuous collision, and the result is written to the bodies.
void finishWorldPoints(SoftBodyData& body, btScalar tick);

/// Wakes all points; they get the gravity of this step that they missed while asleep.
void wakeWorldPoints(SoftBodyData& body, bool insideTick);

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
