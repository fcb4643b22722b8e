// SPDX-License-Identifier: Zlib
#pragma once

#include "bullet/tick_group.h"

#include <vector>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

/// Puts whole groups to sleep and wakes them, by Bullet's own rules (gDeactivationTime, gDisableDeactivation,
/// each body's sleeping threshold, DISABLE_DEACTIVATION).
///
/// Bullet sees no link between the points of a body: left alone it would freeze them one by one. So awake
/// points have their deactivation timer held at 0, and a group goes to sleep in one tick, when all its
/// members have been calm for gDeactivationTime and nothing awake is in contact with any of them. `islands`
/// is scratch.
void updateSleep(std::vector<TickGroup>& groups, btDiscreteDynamicsWorld& world, btScalar tick,
                 std::vector<unsigned char>& islands);

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
