// SPDX-License-Identifier: Zlib
#include "point_adjacency.h"

#include <cstddef>

namespace limber::render {

PointAdjacency makePointAdjacency(const ShapeDesc& desc) {
  const auto pointOf = [&desc](std::size_t corner) {
    const std::uint32_t vertex = desc.triangles[corner];
    return desc.vertexToPoint.empty() ? vertex : desc.vertexToPoint[vertex];
  };
  PointAdjacency adjacency;
  adjacency.offsets.assign(placeCount(desc) + 1, 0);
  for (std::size_t i = 0; i < desc.triangles.size(); ++i) {
    ++adjacency.offsets[pointOf(i) + std::size_t{1}];
  }
  for (std::size_t p = 0; p < placeCount(desc); ++p) {
    adjacency.offsets[p + 1] += adjacency.offsets[p];
  }
  adjacency.corners.resize(2 * desc.triangles.size());
  std::vector<std::uint32_t> next(adjacency.offsets.begin(), adjacency.offsets.end() - 1);
  for (std::size_t i = 0; i < desc.triangles.size(); ++i) {
    const std::size_t first = i - i % 3;
    const std::size_t slot = next[pointOf(i)]++;
    adjacency.corners[2 * slot] = pointOf(first + (i + 1) % 3);
    adjacency.corners[2 * slot + 1] = pointOf(first + (i + 2) % 3);
  }
  return adjacency;
}

}  // namespace limber::render
