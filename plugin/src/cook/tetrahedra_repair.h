// SPDX-License-Identifier: Zlib
#pragma once

#include "cook/tetrahedra.h"

namespace limber {

/// Makes the surface a manifold. Where parts of the body only meet in an edge, all but the largest part's
/// tetrahedra at that edge are taken away; where they only meet in a point, each gets a point of its own.
/// Pieces that no face joins to a larger one and that have less than `leastVolume` (m^3) are taken away.
/// Points that no tetrahedron uses any more are dropped, and the surface is set.
void makeManifold(TetrahedralMesh& mesh, double leastVolume);

/// For each tetrahedron the number of its piece, pieces joined by faces, in the order of their first.
std::vector<std::uint32_t> findPieces(const std::vector<Tetrahedron>& tetrahedra);

}  // namespace limber
