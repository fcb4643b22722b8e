// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/render/image.h>
#include <limber/render/scenery.h>
#include <limber/render/vec3.h>
#include <limber/spring_network.h>

#include <Eigen/Geometry>

#include <string>
#include <vector>

namespace limber::demo {

/// The smallest box around the rest points.
Eigen::AlignedBox3d boundsOf(const SpringNetwork& network);

/// The springs of that kind as lines, or as rods with six sides. No points if there are none.
render::Scenery springLines(const SpringNetwork& network, SpringKind kind);
render::Scenery springRods(const SpringNetwork& network, SpringKind kind, double radius);

/// The surface turned inside out, so that only the walls are drawn whose outside faces away from the viewer,
/// moved outward by `distance` (m), so that it does not cover the springs that lie in it.
render::Scenery farWalls(const SpringNetwork& network, double distance);

struct LegendEntry {
  std::string text;     ///< small letters, digits and blanks; others are left blank
  render::Vec3 colour;  ///< sRGB
};

/// Writes the entries below each other into the upper left corner, each behind a square of its colour, in
/// letters of 1/48 of the picture's height or 7 pixels, whichever is larger.
void drawLegend(render::Image& image, const std::vector<LegendEntry>& entries);

/// The network seen from the front and above, opened towards the viewer: of the surface its far walls, the
/// structural springs as thin lines, all others as rods coloured by kind, and a legend. Throws
/// std::runtime_error with the driver's reason.
render::Image drawNetwork(const SpringNetwork& network, int width, int height);

}  // namespace limber::demo
