// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/result.h>
#include <limber/triangle_mesh.h>

#include <cstdint>

namespace limber {

/// A coarser mesh of about `points` points (never fewer; more where the mesh's topology does not allow it),
/// for the physics of a detailed one: edges are collapsed in the order of their quadric error (Garland,
/// Heckbert 1997) as long as the surface stays manifold and no triangle turns over. Closed meshes stay
/// closed, components stay apart. Normals and texture coordinates are dropped. Errors: those of weld(); fewer
/// than 4 points asked.
Result<TriangleMesh> simplify(const TriangleMesh& mesh, std::uint32_t points);

}  // namespace limber
