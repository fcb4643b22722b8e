// SPDX-License-Identifier: Zlib
#include "core/surface_components.h"

#include "core/disjoint_sets.h"

namespace limber {
namespace {

constexpr std::uint32_t kUnnumbered = 0xffffffffu;

}  // namespace

SurfaceComponents findComponents(std::size_t points, const std::vector<Triangle>& triangles) {
  DisjointSets sets(points);
  for (const Triangle& t : triangles) {
    sets.join(t[0], t[1]);
    sets.join(t[0], t[2]);
  }
  SurfaceComponents components;
  std::vector<std::uint32_t> number(points, kUnnumbered);
  for (const Triangle& t : triangles) {
    std::uint32_t& n = number[sets.root(t[0])];
    if (n == kUnnumbered) n = static_cast<std::uint32_t>(components.count++);
    components.ofTriangle.push_back(n);
  }
  return components;
}

}  // namespace limber
