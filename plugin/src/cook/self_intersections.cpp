// SPDX-License-Identifier: Zlib
#include "cook/self_intersections.h"

#include "cook/triangle_bvh.h"
#include "core/mesh_edges.h"

#include <algorithm>

namespace limber {

std::size_t countPiercingEdges(const std::vector<Eigen::Vector3d>& points,
                               const std::vector<Triangle>& triangles) {
  const TriangleBvh surface(points, triangles);
  const std::vector<Edge> edges = uniqueEdges(triangles);
  const auto pierces = [&](const Edge& edge) {
    const auto apart = [&](std::uint32_t triangle) {
      const Triangle& t = triangles[triangle];
      return std::none_of(t.begin(), t.end(), [&](std::uint32_t i) { return i == edge[0] || i == edge[1]; });
    };
    return surface.isPierced(points[edge[0]], points[edge[1]], apart);
  };
  return static_cast<std::size_t>(std::count_if(edges.begin(), edges.end(), pierces));
}

}  // namespace limber
