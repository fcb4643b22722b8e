// SPDX-License-Identifier: Zlib
#pragma once

#include "bullet/soft_body_data.h"

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

// The two ways a body lives in the world, world_points.h and surface_body.h, by its settings.

void addToWorld(SoftBodyData& body);
void removeFromWorld(SoftBodyData& body);

/// Whether anything of the body is in a world that still exists.
bool anyInWorld(const SoftBodyData& body);

/// Whether everything of it is.
bool wholeInWorld(const SoftBodyData& body);

/// Wakes it; `insideTick`: it also gets the gravity of this step that it missed while asleep.
void wakeBody(SoftBodyData& body, bool insideTick);

/// Whether it moves too much to sleep, see anyPointMoves().
bool isRestless(const SoftBodyData& body, btScalar tick);

// The stages of a tick.
void gatherBody(SoftBodyData& body, btScalar tick);
void handOverBody(SoftBodyData& body, btScalar tick);
void finishBody(SoftBodyData& body, btScalar tick);

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
