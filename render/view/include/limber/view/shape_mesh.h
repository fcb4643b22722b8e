// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/bullet_precision.h>
#include <limber/render/scenery.h>

class btCollisionShape;

namespace limber::view {
inline namespace LIMBER_BULLET_PRECISION {

/// Returns the surface of a collision shape in its own coordinates, with margins where Bullet collides with
/// them: boxes, spheres, capsules, other convex shapes (their hulls: cylinders and cones become polygonal),
/// triangle meshes, height fields, planes (a piece of 100 m) and compounds of these. The result has no
/// triangles if the shape is empty, or of a kind that does not give its surface.
render::Scenery meshOf(const btCollisionShape& shape);

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber::view
