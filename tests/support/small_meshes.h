// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/mesh.h>

/// Tiny meshes with one property each. Their names list all defects.
namespace small_meshes {

using limber::TriangleMesh;

/// Right-angled, legs of 1 m, normal +z.
TriangleMesh singleTriangle();

/// Four points, closed, oriented outward.
TriangleMesh tetrahedron();

/// Edge length 1 m around the origin, n x n cells on each face. The faces share no vertices: the vertices of
/// the 12 seams occur twice, those of the 8 corners three times. 6 n^2 + 2 points.
TriangleMesh cube(int n = 1);

/// Radius 1 m; 12 points without splits, then 42, 162, ... The triangles share no vertices.
TriangleMesh icosphere(int splits);

/// Two tetrahedra that do not touch.
TriangleMesh twoIslands();

/// Three triangles on the edge from vertex 0 to vertex 1.
TriangleMesh nonManifoldEdge();

/// A tetrahedron with one triangle of reversed orientation.
TriangleMesh flippedTriangle();

/// One triangle, and a vertex (index 0) that it does not use.
TriangleMesh isolatedVertex();

/// A triangle whose vertices 0, 1, 2 are on a line, and a valid triangle.
TriangleMesh collinearTriangle();

/// Returns the pieces of both meshes.
TriangleMesh joined(const TriangleMesh& a, const TriangleMesh& b);

/// Returns the mesh with its size times `factor`, moved by `displacement`.
TriangleMesh moved(TriangleMesh mesh, const Eigen::Vector3d& displacement, double factor = 1.0);

/// Returns the mesh with its inside outside.
TriangleMesh inverted(TriangleMesh mesh);

}  // namespace small_meshes
