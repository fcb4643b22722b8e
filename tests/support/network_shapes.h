// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/mesh.h>
#include <limber/network_builder.h>

#include <vector>

/// The shapes on which rigidity, bracing and the networks bench are measured, about 1 m large. The number in
/// a name is the number of points. All except the cloth and the rope are closed and oriented outward.
namespace network_shapes {

using limber::TriangleMesh;

TriangleMesh cube8();             ///< parallel diagonals in opposite faces
TriangleMesh cube8Tetrahedral();  ///< the diagonals are the edges of a tetrahedron
TriangleMesh cube26();            ///< 2 x 2 cells on each face, diagonals that alternate
TriangleMesh cube98();            ///< 4 x 4
TriangleMesh ico42();
TriangleMesh ico162();
TriangleMesh ico642();
TriangleMesh hull60();  ///< convex hull of random points of a sphere; some have three neighbours
TriangleMesh cyl62();   ///< with a fan about the centre of each cap
TriangleMesh cyl60();   ///< caps without further points
TriangleMesh lshape90();
TriangleMesh torus128();
TriangleMesh star162();
TriangleMesh noise162();  ///< smooth, irregular, concave
TriangleMesh noise642();
TriangleMesh rabbit302();        ///< with ears and feet
TriangleMesh tube60();           ///< long and thin, triangular cross-section
TriangleMesh cloth100();         ///< flat, one diagonal in each cell
limber::SharedNetwork rope20();  ///< without bending springs

struct NamedShape {
  const char* name;
  TriangleMesh (*make)();
};

/// Returns all closed shapes.
const std::vector<NamedShape>& solids();

/// Returns a network of the edges of the mesh only.
limber::SharedNetwork bare(const TriangleMesh& mesh);

}  // namespace network_shapes
