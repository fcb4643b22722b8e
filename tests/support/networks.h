// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/network_builder.h>

namespace limber::test {

/// Two points a unit apart along x, one spring.
SharedNetwork pairNetwork();

/// `links` springs of length 1 / links hanging down from the origin; point 0 is the top.
SharedNetwork chainNetwork(int links);

/// The unit cube about the origin: 8 points, 24 springs (edges and both diagonals of every face).
SharedNetwork cubeNetwork();

/// The same with its surface of 12 triangles, which encloses a volume.
SharedNetwork closedCubeNetwork();

/// The unit cube with springs between all pairs: 28, no folded state of zero energy but the mirror image.
SharedNetwork fullCubeNetwork();

/// One regular tetrahedron of edge 1 about the origin, 6 springs.
SharedNetwork tetrahedronNetwork();

/// The unit cube about the origin of six tetrahedra around a diagonal (Kuhn 1960), 19 springs.
SharedNetwork tetrahedralCubeNetwork();

}  // namespace limber::test
