// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/mesh_weld.h>

/// Closed bodies about 1 m large, outward, for tests of what cooking makes of them. Unless said otherwise
/// vertices are shared between triangles.
namespace test_shapes {

using limber::TriangleMesh;

/// Of a sound mesh.
inline limber::WeldedMesh welded(const TriangleMesh& mesh) { return *limber::weld(mesh); }

// Those of the folder meshes, without texture coordinates, vertices of its own for each triangle.
TriangleMesh lShape();    ///< 90 points
TriangleMesh torus();     ///< 128 points
TriangleMesh cylinder();  ///< with a fan at each end
TriangleMesh star();      ///< 162 points
TriangleMesh figure();    ///< about 300 points; arms, legs and ears

/// An icosphere of diameter about 1 whose radius varies smoothly and irregularly by a third; 162 points with
/// 2 splits. Vertices of its own for each triangle.
TriangleMesh noiseSphere(int splits);

/// Fields sampled in cells of `cell` metres.
TriangleMesh rabbit(double cell);     ///< two ears, 0.05 m apart at the tips
TriangleMesh horseshoe(double cell);  ///< a bent rod whose ends are 0.05 m apart, at x = -0.025 and 0.025
TriangleMesh roundTorus(double cell);

}  // namespace test_shapes
