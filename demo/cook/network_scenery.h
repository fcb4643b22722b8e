// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/render/scenery.h>
#include <limber/spring_network.h>

#include <Eigen/Geometry>

namespace limber::demo {

/// The smallest box around the rest points.
Eigen::AlignedBox3d boundsOf(const SpringNetwork& network);

/// The springs of that kind as lines, or as rods with six sides. No points if there are none.
render::Scenery springLines(const SpringNetwork& network, SpringKind kind);
render::Scenery springRods(const SpringNetwork& network, SpringKind kind, double radius);

/// The surface turned inside out, so that only the walls are drawn whose outside faces away from the viewer,
/// moved outward by `distance` (m), so that it does not cover the springs that lie in it.
render::Scenery farWalls(const SpringNetwork& network, double distance);

}  // namespace limber::demo
