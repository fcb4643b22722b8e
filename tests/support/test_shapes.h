// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/mesh.h>

/// Closed meshes about 1 m large, oriented outward, for tests of cooking. Triangles share vertices unless
/// stated otherwise.
namespace test_shapes {

using limber::TriangleMesh;

/// Welds a valid mesh.
inline limber::WeldedMesh welded(const TriangleMesh& mesh) { return *limber::weld(mesh); }

// The shapes of the folder meshes, without texture coordinates. The triangles share no vertices.
TriangleMesh lShape();    ///< 90 points
TriangleMesh torus();     ///< 128 points
TriangleMesh cylinder();  ///< with a fan at each end
TriangleMesh star();      ///< 162 points
TriangleMesh figure();    ///< about 300 points; arms, legs and ears

/// An icosphere of diameter about 1 whose radius varies smoothly and irregularly by a third; 162 points with
/// 2 splits. The triangles share no vertices.
TriangleMesh noiseSphere(int splits);

/// Surfaces of fields that are sampled in cells of `cell` metres.
TriangleMesh rabbit(double cell);     ///< two ears, 0.05 m apart at the tips
TriangleMesh horseshoe(double cell);  ///< a bent rod whose ends are 0.05 m apart, at x = -0.025 and 0.025
TriangleMesh roundTorus(double cell);

}  // namespace test_shapes
