// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/bullet_precision.h>

#include <btBulletDynamicsCommon.h>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

/// Lets the dispatcher treat spheres on boxes by Bullet's closed form (btSphereBoxCollisionAlgorithm) instead
/// of its general convex algorithm, from its next new pair on: faster, and more exact: in single precision
/// the general one now and then finds a sphere that rests on a box centimetres above it. It concerns loose
/// spheres and the point masses of bodies with Collision::Points; contacts with spheres and triangles have
/// closed forms anyhow.
void useFastSphereAlgorithms(btCollisionDispatcher& dispatcher);

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
