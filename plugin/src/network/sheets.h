// SPDX-License-Identifier: Zlib
// Declares the recognition of meshes that are sheets or thin tubes, and the networks made of them.
#pragma once

#include <limber/cook.h>
#include <limber/mesh.h>

#include <cstddef>
#include <optional>

namespace limber {

/// Returns a cloth if the mesh is one piece that is flat, or open with a border that is long for its area: as
/// a disc has it, and not a ball with holes. Of a flat closed plate it is the front side. The cloth has the
/// mesh's points, or about `points` (0: 800) if these are more; coarse meshes are divided so that they can
/// fold. Its thickness is that of the plate, or half a
/// percent of the size.
std::optional<CookedBody> sheetOf(const TriangleMesh& mesh, const WeldedMesh& welded, std::size_t points);

/// Returns a rope along the middle of the mesh if this is one piece, a tube without branches that is at least
/// 25 times as long as it is thick.
std::optional<CookedBody> ropeOf(const WeldedMesh& welded);

}  // namespace limber
