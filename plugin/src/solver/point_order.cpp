// SPDX-License-Identifier: Zlib
#include "solver/point_order.h"

#include <algorithm>

namespace limber {
namespace {

using Neighbours = std::vector<std::vector<std::uint32_t>>;

Neighbours neighboursOf(const SpringArrays& springs, std::size_t points) {
  Neighbours neighbours(points);
  for (std::size_t s = 0; s < springs.size(); ++s) {
    neighbours[springs.a[s]].push_back(springs.b[s]);
    neighbours[springs.b[s]].push_back(springs.a[s]);
  }
  const auto fewer = [&](std::uint32_t a, std::uint32_t b) {
    return neighbours[a].size() != neighbours[b].size() ? neighbours[a].size() < neighbours[b].size() : a < b;
  };
  Neighbours sorted = neighbours;
  for (auto& list : sorted) std::sort(list.begin(), list.end(), fewer);
  return sorted;
}

/// Appends the points that can be reached from `start`, nearest first.
void visitFrom(std::uint32_t start, const Neighbours& neighbours, std::vector<unsigned char>& seen,
               std::vector<std::uint32_t>& order) {
  std::size_t next = order.size();
  order.push_back(start);
  seen[start] = 1;
  for (; next < order.size(); ++next)
    for (const std::uint32_t i : neighbours[order[next]])
      if (!seen[i]) {
        seen[i] = 1;
        order.push_back(i);
      }
}

/// The point of a component from which the others are farthest, found by going to the far end twice.
std::uint32_t farEnd(std::uint32_t start, const Neighbours& neighbours) {
  for (int pass = 0; pass < 2; ++pass) {
    std::vector<unsigned char> seen(neighbours.size(), 0);
    std::vector<std::uint32_t> order;
    visitFrom(start, neighbours, seen, order);
    start = order.back();
  }
  return start;
}

}  // namespace

std::vector<std::uint32_t> bandOrder(const SpringArrays& springs, std::size_t points) {
  const Neighbours neighbours = neighboursOf(springs, points);
  std::vector<unsigned char> seen(points, 0);
  std::vector<std::uint32_t> order;
  for (std::uint32_t i = 0; i < points; ++i)
    if (!seen[i]) visitFrom(farEnd(i, neighbours), neighbours, seen, order);
  std::vector<std::uint32_t> place(points);
  for (std::uint32_t k = 0; k < points; ++k) place[order[k]] = static_cast<std::uint32_t>(points) - 1 - k;
  return place;
}

std::size_t bandWidth(const SpringArrays& springs, const std::vector<std::uint32_t>& place) {
  std::size_t width = 0;
  for (std::size_t s = 0; s < springs.size(); ++s) {
    const auto a = place[springs.a[s]], b = place[springs.b[s]];
    width = std::max<std::size_t>(width, a > b ? a - b : b - a);
  }
  return width;
}

}  // namespace limber
