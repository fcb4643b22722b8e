// SPDX-License-Identifier: Zlib
#pragma once

#include "bullet/shape_cache.h"
#include "solver/held_surface.h"

#include <Eigen/Geometry>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

/// Whether a static or kinematic object moves in this tick; while kinematic ones are Rewound.
bool isMoved(const btCollisionObject& object);

/// Adds what an object's shape has in a box (m, in the world): convex solids as a whole, hulls of many faces
/// and sheets by triangles. Each solid is an owner of its own, numbered from `owner` on, and so is each sheet.
/// Returns the next number.
std::uint32_t addPieces(const btCollisionObject& object, const Eigen::AlignedBox3d& box, ShapeCache& shapes,
                        std::uint32_t owner, std::vector<HeldPiece>& pieces);

/// Whether the pieces are flat within `reach` of the place on each that is nearest to `x`, or farther away
/// than that; `radius` is that of the point at x.
bool areFlatAround(const HeldPiece* begin, const HeldPiece* end, const Eigen::Vector3d& x, double radius,
                   double reach);

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
