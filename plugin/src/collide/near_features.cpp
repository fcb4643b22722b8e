// SPDX-License-Identifier: Zlib
#include "collide/near_features.h"

#include "collide/edge_contacts.h"
#include "collide/vertex_triangle.h"

namespace limber {
namespace {

/// An element with the boxes of what is in its care.
struct BoxedElement {
  const SurfaceElement* element = nullptr;
  SweptBox whole;
  std::array<SweptBox, 3> edges;
  const std::vector<SweptBox>* points = nullptr;

  const SweptBox& vertexBox(std::uint32_t v) const { return (*points)[v]; }
};

BoxedElement boxed(const MovingSurface& surface, std::uint32_t leaf) {
  const std::vector<SweptBox>& points = surface.boxes->points;
  BoxedElement boxed;
  boxed.element = &surface.topology->elements[surface.topology->nodes[leaf].element];
  boxed.whole = surface.boxes->nodes[leaf];
  boxed.points = &points;
  for (std::size_t i = 0; i < 3; ++i) {
    if (boxed.element->edges[i] == kNoFeature) continue;
    const Edge& ends = surface.topology->edges[boxed.element->edges[i]];
    boxed.edges[i] = merged(points[ends[0]], points[ends[1]]);
  }
  return boxed;
}

/// The vertices in the care of `mine` against all that is in the care of `other`; `ofB` tells whose they are.
void meetVerticesOf(const SurfacePair& pair, bool ofB, const BoxedElement& mine, const BoxedElement& other,
                    ContactSearch& search) {
  for (const std::uint32_t v : mine.element->vertices) {
    if (v == kNoFeature || separation(mine.vertexBox(v), other.whole) > pair.margin) continue;
    const SweptBox& box = mine.vertexBox(v);
    if (other.element->triangle != kNoFeature)
      meetVertexTriangle(pair, ofB, v, other.element->triangle, search);
    for (std::size_t i = 0; i < 3; ++i)
      if (other.element->edges[i] != kNoFeature && separation(box, other.edges[i]) <= pair.margin)
        meetVertexEdge(pair, ofB, v, other.element->edges[i], search);
    for (const std::uint32_t w : other.element->vertices)
      if (!ofB && w != kNoFeature && separation(box, other.vertexBox(w)) <= pair.margin)
        meetVertices(pair, v, w, search);
  }
}

void meetEdgesOf(const SurfacePair& pair, const BoxedElement& a, const BoxedElement& b,
                 ContactSearch& search) {
  for (std::size_t i = 0; i < 3; ++i) {
    if (a.element->edges[i] == kNoFeature || separation(a.edges[i], b.whole) > pair.margin) continue;
    for (std::size_t j = 0; j < 3; ++j)
      if (b.element->edges[j] != kNoFeature && separation(a.edges[i], b.edges[j]) <= pair.margin)
        meetEdges(pair, a.element->edges[i], b.element->edges[j], search);
  }
}

}  // namespace

void meetNearFeatures(const SurfacePair& pair, ContactSearch& search) {
  std::uint32_t leafA = kNoFeature, leafB = kNoFeature;
  BoxedElement a, b;
  for (const auto& [i, j] : search.near) {
    if (i != leafA) a = boxed(pair.a, leafA = i);
    if (j != leafB) b = boxed(pair.b, leafB = j);
    meetVerticesOf(pair, false, a, b, search);
    meetVerticesOf(pair, true, b, a, search);
    meetEdgesOf(pair, a, b, search);
  }
}

}  // namespace limber
