// SPDX-License-Identifier: Zlib
#pragma once

#include "bullet/soft_body_data.h"

#include <Eigen/Geometry>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

/// Before a tick: gives every awake surface body of `system` the static and kinematic objects that Bullet's
/// broadphase found near it (surface.partners, in order of their unique ids), and wakes those that sleep
/// where a kinematic object is awake, as Bullet's islands do.
/// One pass over the pairs instead of one query per body.
void collectPartners(btDiscreteDynamicsWorld& world, const void* system);

/// Whether surface.partners holds everything that may touch something in this box (m) in the coming tick:
/// Bullet's broadphase has looked there.
bool partnersCover(const SoftBodyData& body, const Eigen::AlignedBox3d& box);

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
