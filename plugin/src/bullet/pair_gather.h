// SPDX-License-Identifier: Zlib
#pragma once

#include "bullet/soft_body_data.h"
#include "bullet/tick_contacts.h"

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

struct TickGroup;

/// Adds to `found` a contact for every surface of a rigid body that moves by itself and that a point of the
/// body may reach in the coming tick, before it touches: Bullet's narrowphase finds it. A partner that is
/// asleep is woken.
void gatherPairs(SoftBodyData& body, btRigidBody& partner, btScalar tick, TickContacts& found);

/// Adds a contact for every two point masses in the world, of different bodies, that may meet in the coming tick.
/// Call it when all awake groups have been gathered.
void gatherPointPairs(const std::vector<TickGroup>& groups, btScalar tick, TickContacts& found);

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
