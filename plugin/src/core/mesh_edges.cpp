// SPDX-License-Identifier: Zlib
#include "core/mesh_edges.h"

#include <algorithm>

namespace limber {
namespace {

/// One side of a triangle: the edge, and whether the triangle runs through it from the smaller index up.
struct HalfEdge {
  Edge edge;
  bool upward;
};

HalfEdge halfEdge(std::uint32_t from, std::uint32_t to) {
  return from < to ? HalfEdge{{from, to}, true} : HalfEdge{{to, from}, false};
}

std::vector<HalfEdge> sortedHalfEdges(const std::vector<Triangle>& triangles) {
  std::vector<HalfEdge> sides;
  sides.reserve(3 * triangles.size());
  for (const Triangle& t : triangles) {
    for (std::size_t corner = 0; corner < 3; ++corner)
      sides.push_back(halfEdge(t[corner], t[(corner + 1) % 3]));
  }
  std::sort(sides.begin(), sides.end(), [](const HalfEdge& s, const HalfEdge& t) { return s.edge < t.edge; });
  return sides;
}

}  // namespace

std::vector<Edge> uniqueEdges(const std::vector<Triangle>& triangles) {
  std::vector<Edge> edges;
  for (const HalfEdge& side : sortedHalfEdges(triangles)) {
    if (edges.empty() || edges.back() != side.edge) edges.push_back(side.edge);
  }
  return edges;
}

EdgeDefects findEdgeDefects(const std::vector<Triangle>& triangles) {
  const std::vector<HalfEdge> sides = sortedHalfEdges(triangles);
  EdgeDefects defects;
  for (std::size_t first = 0, last = 0; first < sides.size(); first = last) {
    while (last < sides.size() && sides[last].edge == sides[first].edge) ++last;
    const std::size_t uses = last - first;
    if (uses == 1) ++defects.open;
    if (uses > 2) ++defects.nonManifold;
    if (uses == 2 && sides[first].upward == sides[first + 1].upward) ++defects.inconsistent;
  }
  return defects;
}

}  // namespace limber
