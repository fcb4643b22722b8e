// SPDX-License-Identifier: Zlib
#pragma once

#include "bullet/soft_body_data.h"

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

// How a body with Collision::Surface lives in the world: one object stands for it, the point masses are
// outside, and nothing is handed to Bullet's solver or taken back from it.

inline bool isSurfaceBody(const SoftBodyData& body) { return body.settings.collision == Collision::Surface; }

/// Makes the point masses and the object, and adds the object to the world.
void addSurface(SoftBodyData& body);

/// Deletes what the application has not deleted. A world that is gone is not touched.
void removeSurface(SoftBodyData& body);

/// Called by ~SurfaceObject when the application deletes it.
void forgetDeletedSurface(SoftBodyData& body);

/// From now on the point masses are kept up to date and read: somebody outside has one.
void sharePoints(SoftBodyData& body);

/// Moves the forces that the user has applied to the points since the last call into surface.force.
void collectForces(SoftBodyData& body);

/// gatherPoints(), and the accelerations from gravity and forces.
void gatherSurface(SoftBodyData& body, btScalar tick);

/// At the start of a tick: where a body that has been thrown since the last one may get is told to Bullet's broadphase,
/// in which others look for it.
void showFlight(SoftBodyData& body, btScalar tick);

/// After the step: gives the broadphase the box of this tick's motion and of what the points may reach in the
/// next.
void handOverBox(SoftBodyData& body, btScalar tick);

/// After the tick: Bullet's linear damping of the points, continuous collision, and the result written to the
/// point masses and the object.
void finishSurface(SoftBodyData& body, btScalar tick);

/// As anyPointMoves().
bool anySurfacePointMoves(const SoftBodyData& body, btScalar tick);

/// Whether the user has changed a point of a sleeping body.
bool isSurfaceChanged(const SoftBodyData& body);

/// Wakes the object, and the point masses if they are shared.
void wakeSurface(SoftBodyData& body);

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
