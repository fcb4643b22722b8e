// SPDX-License-Identifier: Zlib
#include "core/surface_components.h"

#include <algorithm>
#include <numeric>

namespace limber {
namespace {

std::uint32_t findRoot(std::vector<std::uint32_t>& parent, std::uint32_t point) {
  while (parent[point] != point) {
    parent[point] = parent[parent[point]];
    point = parent[point];
  }
  return point;
}

constexpr std::uint32_t kUnnumbered = 0xffffffffu;

}  // namespace

SurfaceComponents findComponents(std::size_t points, const std::vector<Triangle>& triangles) {
  std::vector<std::uint32_t> parent(points);
  std::iota(parent.begin(), parent.end(), 0u);
  for (const Triangle& t : triangles) {
    for (const std::uint32_t corner : {t[1], t[2]}) {
      const std::uint32_t root = findRoot(parent, t[0]), other = findRoot(parent, corner);
      parent[std::max(root, other)] = std::min(root, other);
    }
  }
  SurfaceComponents components;
  std::vector<std::uint32_t> number(points, kUnnumbered);
  for (const Triangle& t : triangles) {
    std::uint32_t& n = number[findRoot(parent, t[0])];
    if (n == kUnnumbered) n = static_cast<std::uint32_t>(components.count++);
    components.ofTriangle.push_back(n);
  }
  return components;
}

}  // namespace limber
