// SPDX-License-Identifier: Zlib
#pragma once

#include "cook/solid_surface.h"
#include "cook/tetrahedra.h"

namespace limber {

/// The smallest and the largest angle (degrees) that fitSurface() leaves, unless they were there before.
constexpr double kSmallestAngle = 18.0, kLargestAngle = 145.0;

/// Draws the points of the surface to where the planes of the given surface around them meet (the least
/// squares of M. Garland, P. Heckbert, "Surface simplification using quadric error metrics", SIGGRAPH 1997),
/// so that sharp edges and corners, which the lattice cuts off, come back, and round bodies keep their
/// volume; and evens out the points inside. Points move one after the other, as far as the angles allow.
void fitSurface(TetrahedralMesh& mesh, const SolidSurface& surface);

}  // namespace limber
