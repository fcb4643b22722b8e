// SPDX-License-Identifier: Zlib
#pragma once

#include "bullet/soft_body_data.h"

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

/// Fills body.contacts with a row for every static or kinematic surface that a point may reach in the coming
/// tick, before it touches. Bullet's broadphase names the partners. Static ones are taken apart
/// (held_pieces.h): where all that a point may reach is flat it has rows of planes, else rows that follow the
/// surface within the tick. On kinematic ones that move, Bullet's narrowphase finds planes; slow points keep
/// that of the last tick (PointMass::cachedContact). What moves by itself is in pair_gather.h. Call after
/// gatherPoints().
void gatherContacts(SoftBodyData& body, btScalar tick);

/// Makes body.watch, which finds what a point meets that gets farther within a tick than gatherContacts() has
/// looked for: springs and neighbours may throw it. It is on while something is near.
void addContactWatch(SoftBodyData& body);

/// After a step without the watch: whether a point that got out of its reach may have met something. Then the
/// body must be stepped again, with the watch.
bool mayHaveMissedContacts(SoftBodyData& body);


}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
