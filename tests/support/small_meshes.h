// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/triangle_mesh.h>

/// Tiny meshes with one property each. All are sound but for what their name says.
namespace small_meshes {

using limber::TriangleMesh;

/// Right-angled, legs of 1 m, normal +z.
TriangleMesh singleTriangle();

/// Four points, closed, oriented outward.
TriangleMesh tetrahedron();

/// Edge length 1 m around the origin, n x n cells on each face and vertices of its own for each face: the
/// vertices of the 12 seams occur twice, those of the 8 corners three times. 6 n^2 + 2 points.
TriangleMesh cube(int n = 1);

/// Radius 1 m; 12 points without splits, then 42, 162, ... Vertices of its own for each triangle.
TriangleMesh icosphere(int splits);

/// Two tetrahedra that do not touch.
TriangleMesh twoIslands();

/// Three triangles on the edge from vertex 0 to vertex 1.
TriangleMesh nonManifoldEdge();

/// A tetrahedron with one triangle the wrong way around.
TriangleMesh flippedTriangle();

/// One triangle and a vertex, index 0, that it does not use.
TriangleMesh isolatedVertex();

/// The vertices 0, 1, 2 on a line, and a sound triangle.
TriangleMesh collinearTriangle();

}  // namespace small_meshes
