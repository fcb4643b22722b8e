// SPDX-License-Identifier: Zlib
#pragma once

#include "implicit_shapes.h"
#include "triangle_soup.h"

#include <array>
#include <cstdint>
#include <vector>

namespace shapes {

/// Cubic cells that enclose the body.
struct CellGrid {
  Eigen::Vector3d low;    ///< the lowest corner, metres
  double width;           ///< of a cell, metres
  Eigen::Vector3i cells;  ///< along x, y, z
};

/// Cells of `width` with corners at multiples of it, around a box and one cell wider at each side.
CellGrid gridAround(const Eigen::Vector3d& low, const Eigen::Vector3d& high, double width);

/// Quads counter-clockwise seen from outside, vertex indices.
struct QuadMesh {
  std::vector<Eigen::Vector3d> vertices;
  std::vector<std::array<std::uint32_t, 4>> quads;
};

/// The surface between inside and outside: one vertex for each cell that the surface crosses, one quad around
/// each grid edge that it crosses (S. Gibson, "Constrained elastic surface nets", 1998).
QuadMesh buildSurfaceNet(const Field& field, const CellGrid& grid);

/// Moves the vertices towards the middle of their neighbours and back onto the surface, `rounds` times.
void relaxOnSurface(QuadMesh& mesh, const Field& field, int rounds);

/// The surface of the body in the box, made of cells of `width`, relaxed and split.
TriangleSoup makeBody(const Field& field, const Eigen::Vector3d& low, const Eigen::Vector3d& high,
                      double width);

/// Each quad as two triangles, split along its shorter diagonal; all texture coordinates are 0. Diagonals
/// count as equal if they differ by less than this share: then the result does not depend on rounding errors.
TriangleSoup toSoup(const QuadMesh& mesh, double equal = 1e-9);

}  // namespace shapes
