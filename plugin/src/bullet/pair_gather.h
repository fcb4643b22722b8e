// SPDX-License-Identifier: Zlib
#pragma once

#include "bullet/soft_body_data.h"
#include "bullet/tick_contacts.h"

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

/// Adds to `found` a contact for every surface of a rigid body that moves by itself and that a point of the
/// body may reach in the coming tick, before it touches. Those that are asleep are woken. Call after
/// gatherContacts(), which has looked for body.freePartners.
void gatherPairs(SoftBodyData& body, btScalar tick, TickContacts& found);

/// After the step: remembers what the body's contacts in `contacts` bore. Call it once for all bodies.
void rememberPairs(const std::vector<SoftBodyData*>& bodies, const TickContacts& contacts);

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
