// SPDX-License-Identifier: Zlib
#pragma once

#include <Eigen/Core>

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

namespace shapes {

/// Below 0 inside the body, above 0 outside.
using Field = std::function<double(const Eigen::Vector3d&)>;

/// Cubic cells that enclose the body.
struct CellGrid {
  Eigen::Vector3d low;    ///< the lowest corner, metres
  double width;           ///< of a cell, metres
  Eigen::Vector3i cells;  ///< along x, y, z
};

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

}  // namespace shapes
