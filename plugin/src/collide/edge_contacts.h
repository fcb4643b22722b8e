// SPDX-License-Identifier: Zlib
#pragma once

#include "collide/contact_candidates.h"

namespace limber {

// Features of a and b that touch at edges and corners: a candidate is added where they are locally nearest,
// now or when they meet.

/// Vertices of a and b.
void meetVertices(const SurfacePair& pair, std::uint32_t va, std::uint32_t vb, ContactSearch& search);

/// A vertex of a and an edge of b, or (`ofB`) a vertex of b and an edge of a.
void meetVertexEdge(const SurfacePair& pair, bool ofB, std::uint32_t v, std::uint32_t edge,
                    ContactSearch& search);

/// Edges of a and b that cross. Those of solid bodies may have passed through each other by less than the
/// depth limit of their triangles.
void meetEdges(const SurfacePair& pair, std::uint32_t ea, std::uint32_t eb, ContactSearch& search);

}  // namespace limber
