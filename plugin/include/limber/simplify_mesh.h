// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/result.h>
#include <limber/triangle_mesh.h>

#include <cstdint>

namespace limber {

/// Returns a coarser mesh of about `points` points, for the physics of a detailed mesh. It never has fewer
/// points, and has more where the topology of the mesh requires it. Edges are collapsed in the order of their
/// quadric error (Garland, Heckbert 1997) as long as the surface stays manifold and no triangle flips. Closed
/// meshes stay closed; components stay separate. Normals and texture coordinates are dropped. Errors: those
/// of weld(); `points` below 4.
Result<TriangleMesh> simplify(const TriangleMesh& mesh, std::uint32_t points);

}  // namespace limber
