// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/bullet_precision.h>
#include <limber/render/scenery.h>

class btCollisionShape;

namespace limber::view {
inline namespace LIMBER_BULLET_PRECISION {

/// The surface of a collision shape in its own coordinates, margins included where Bullet collides with them:
/// boxes, spheres, capsules, other convex shapes (hulls of them: corners of cylinders and cones as polygons),
/// triangle meshes, height fields, planes (a piece of 100 m) and compounds of these. Without triangles if the
/// shape has no surface (an empty one) or is of a kind that cannot tell.
render::Scenery meshOf(const btCollisionShape& shape);

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber::view
