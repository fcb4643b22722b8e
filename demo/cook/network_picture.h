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

/// Returns the smallest box around the rest points.
Eigen::AlignedBox3d boundsOf(const SpringNetwork& network);

/// Return the springs of that kind as lines, or as rods with six sides. Without such springs the result has
/// no points.
render::Scenery springLines(const SpringNetwork& network, SpringKind kind);
render::Scenery springRods(const SpringNetwork& network, SpringKind kind, double radius);

/// Returns the surface turned inside out, so that only walls are drawn whose outside faces away from the
/// viewer. It is moved outward by `distance` (m), so that it does not hide the springs in it.
render::Scenery farWalls(const SpringNetwork& network, double distance);

struct LegendEntry {
  std::string text;     ///< ASCII
  render::Vec3 colour;  ///< sRGB
};

/// Writes the entries below each other into the upper left corner, each after a square of its colour. The
/// height of letters is 1/48 of the picture's height, at least 7 pixels.
void drawLegend(render::Image& image, const std::vector<LegendEntry>& entries);

/// Draws the network from the front and above: the far walls of its surface, the structural springs as thin
/// lines, all other springs as rods coloured by kind, and a legend with their numbers. If there are braces,
/// springs in front of a plane through the middle are left out: the body is cut open. Throws
/// std::runtime_error with the driver's reason.
render::Image drawNetwork(const SpringNetwork& network, int width, int height);

}  // namespace limber::demo
