// SPDX-License-Identifier: Zlib
#pragma once

#include "bullet/tick_group.h"

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

/// Before the step: sets the group's stepper and substeps for this tick.
void chooseStepping(TickGroup& group, double tick);

/// Before the step of a cluster that is this group and nothing else that moves by itself or as told, with a
/// budget that leaves its oscillations next to unresolved: its energy must not rise while it is so. With false:
/// of any other cluster.
void guardCluster(TickGroup& group, bool alone);

/// Whether the group's bodies ask for an error tolerance, so that a tick may have to be stepped again.
bool hasTolerance(const TickGroup& group);

/// Steps the group; with a tolerance again, more finely, where the error turns out larger than foreseen.
void stepGroup(TickGroup& group, double tick, SharedFactors& factors);

/// After the step of a group that is in no cluster: steps it again with watches on (contact_gather.h) where
/// a point got farther than contacts were looked for, and something is there.
void repeatIfMissed(TickGroup& group, double tick, SharedFactors& factors);

/// After the step: what the bodies tell of it.
void reportStepping(TickGroup& group, double tick);

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
