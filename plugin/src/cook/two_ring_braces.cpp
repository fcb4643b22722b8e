// SPDX-License-Identifier: Zlib
#include "cook/two_ring_braces.h"

#include <algorithm>

namespace limber {

std::vector<Edge> findTwoRingPairs(std::size_t points, const std::vector<Edge>& edges) {
  std::vector<std::vector<std::uint32_t>> neighbours(points);
  for (const Edge& e : edges) {
    neighbours[e[0]].push_back(e[1]);
    neighbours[e[1]].push_back(e[0]);
  }
  std::vector<Edge> pairs;
  for (const std::vector<std::uint32_t>& around : neighbours)
    for (const std::uint32_t a : around)
      for (const std::uint32_t b : around)
        if (a < b && !std::binary_search(edges.begin(), edges.end(), Edge{a, b})) pairs.push_back({a, b});
  std::sort(pairs.begin(), pairs.end());
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  return pairs;
}

}  // namespace limber
