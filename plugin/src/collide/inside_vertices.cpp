// SPDX-License-Identifier: Zlib
#include "collide/inside_vertices.h"

#include "collide/normal_cone.h"
#include "collide/vertex_triangle.h"

#include <algorithm>
#include <tuple>

namespace limber {
namespace {

using Eigen::Vector3d;
using Behind = std::vector<VertexBehind>::const_iterator;

Vector3d normalAt(const MovingSurface& surface, std::uint32_t triangle) {
  return normalOf<3>(featureOf<3>(surface, surface.topology->triangles[triangle]).start);
}

/// What is nearest to a vertex inside is something it is behind of. One triangle is as near as `depth`.
bool isBehindNearest(const MovingSurface& surface, const Vector3d& position, double depth) {
  constexpr double kRounding = 1.001;
  return nearestOnSurface(surface, position, kRounding * depth).behind;
}

/// `begin` to `end` are one vertex, the nearest triangle first.
void addInside(const SurfacePair& pair, Behind begin, Behind end, ContactSearch& search) {
  const MovingSurface &mine = begin->ofB ? pair.b : pair.a, &other = begin->ofB ? pair.a : pair.b;
  const auto less = [](const VertexBehind& x, const VertexBehind& y) { return x.depth < y.depth; };
  const double depth = std::min_element(begin, end, less)->depth;
  if (!isBehindNearest(other, mine.position->col(begin->vertex), depth)) return;
  const auto facing = std::find_if(begin, end, [&](const VertexBehind& at) {
    return facesOutward(mine, 0.0, at.vertex, -normalAt(other, at.triangle));
  });
  const VertexBehind& at = facing != end ? *facing : *begin;
  addVertexOnTriangle(pair, at, normalAt(other, at.triangle), 0.0, search);
}

}  // namespace

void addInsideVertices(const SurfacePair& pair, ContactSearch& search) {
  const auto order = [](const VertexBehind& at) {
    return std::make_tuple(at.ofB, at.vertex, !at.beneath, at.depth, at.triangle);
  };
  std::sort(search.behind.begin(), search.behind.end(),
            [&](const VertexBehind& x, const VertexBehind& y) { return order(x) < order(y); });
  for (Behind begin = search.behind.begin(), end = begin; begin != search.behind.end(); begin = end) {
    while (end != search.behind.end() && end->ofB == begin->ofB && end->vertex == begin->vertex) ++end;
    addInside(pair, begin, end, search);
  }
}

}  // namespace limber
