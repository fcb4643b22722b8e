// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/bullet_precision.h>

#include <btBulletDynamicsCommon.h>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

/// Lets the dispatcher treat spheres on boxes by Bullet's closed form (btSphereBoxCollisionAlgorithm) instead
/// of its general convex algorithm, from its next new pair on. It concerns loose spheres and the point masses
/// of bodies with Collision::Points; contacts with spheres and triangles have closed forms anyhow.
void useFastSphereAlgorithms(btCollisionDispatcher& dispatcher);

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
