// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/bullet_precision.h>

#include <btBulletDynamicsCommon.h>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

/// Makes the dispatcher compute contacts between spheres and boxes with Bullet's closed form
/// (btSphereBoxCollisionAlgorithm) instead of its general convex algorithm. This holds for pairs that are
/// created later. The closed form is faster and more exact: in single precision the general algorithm
/// sometimes reports a sphere that rests on a box as centimetres above it. Single spheres and the point
/// masses of bodies with Collision::Points are affected. Contacts of spheres with spheres or triangles
/// already have closed forms.
void useFastSphereAlgorithms(btCollisionDispatcher& dispatcher);

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
