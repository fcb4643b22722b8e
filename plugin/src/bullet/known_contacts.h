// SPDX-License-Identifier: Zlib
#pragma once

#include "bullet/soft_body_data.h"
#include "bullet/tick_contacts.h"

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

/// Starts the contacts of soft bodies from what those of the same features bore in the last tick.
void guessBearings(TickContacts& contacts);

/// After the step: remembers what they bore. `bodies`: all of the system.
void rememberBearings(const std::vector<SoftBodyData*>& bodies, const TickContacts& contacts);

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
