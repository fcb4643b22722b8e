// SPDX-License-Identifier: Zlib
#pragma once

#include "bullet/cluster.h"

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

/// Moves the contacts with static and kinematic surfaces of those points that something free touches or holds,
/// from their bodies' rows to the cluster's pairs: what is squeezed between the two must be solved with both.
void appendRows(Cluster& cluster);

/// After the step: gives these rows what they bore.
void reportRows(Cluster& cluster);

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
