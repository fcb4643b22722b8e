// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/network_builder.h>

namespace limber::test {

/// Returns two points with a distance of 1 along x and one spring.
SharedNetwork pairNetwork();

/// Returns `links` springs of length 1 / links that hang down from the origin; point 0 is the top.
SharedNetwork chainNetwork(int links);

/// Returns the unit cube about the origin: 8 points, 24 springs (edges and both diagonals of every face).
SharedNetwork cubeNetwork();

/// Returns the same with a closed surface of 12 triangles.
SharedNetwork closedCubeNetwork();

/// Returns the unit cube with springs between all pairs of points: 28. Its only other state of zero energy is
/// the mirror image.
SharedNetwork fullCubeNetwork();

/// Returns one regular tetrahedron with edges of 1 about the origin, 6 springs.
SharedNetwork tetrahedronNetwork();

/// Returns the unit cube about the origin, made of six tetrahedra around a diagonal (Kuhn 1960), 19 springs.
SharedNetwork tetrahedralCubeNetwork();

/// Returns a block of nx x ny x nz such cubes from the origin.
SharedNetwork tetrahedralBlockNetwork(int nx, int ny, int nz);

/// Returns a cloth of columns x rows fields with the other standard settings.
SharedNetwork clothNetwork(std::uint32_t columns, std::uint32_t rows, double width = 1.0, double depth = 1.0);

/// Returns a square cloth of cells x cells fields.
SharedNetwork squareCloth(std::uint32_t cells, double width = 1.0);

SharedNetwork ropeNetwork(std::uint32_t segments, double length = 1.0);

/// Returns the mesh filled with tetrahedra of about `points` point masses. Tests share what was built.
SharedNetwork solidNetwork(const TriangleMesh& mesh, std::uint32_t points);

/// Returns the mesh with the default braces. Tests share what was built.
SharedNetwork bracedNetwork(const TriangleMesh& mesh);

}  // namespace limber::test
