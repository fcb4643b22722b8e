// SPDX-License-Identifier: Zlib
#include "cook/inside_chords.h"

#include <algorithm>

namespace limber {
namespace {

/// Share of the size by which a chord may leave the surface: rounding of coordinates in single precision.
constexpr double kTolerance = 1e-6;

std::uint64_t keyOf(std::uint32_t a, std::uint32_t b) {
  return static_cast<std::uint64_t>(std::min(a, b)) << 32 | std::max(a, b);
}

}  // namespace

InsideChords::InsideChords(const std::vector<Eigen::Vector3d>& points, const std::vector<Triangle>& triangles,
                           const std::vector<Edge>& edges)
    : points_(points), size_(extent(points)), surface_(points, triangles), neighbours_(points.size()) {
  for (const Edge& e : edges) join(e[0], e[1]);
}

bool InsideChords::joined(std::uint32_t a, std::uint32_t b) const {
  const std::vector<std::uint32_t>& of = neighbours_[a];
  return a == b || std::find(of.begin(), of.end(), b) != of.end();
}

bool InsideChords::allowed(std::uint32_t a, std::uint32_t b) {
  if (joined(a, b)) return false;
  const auto [known, isNew] = inside_.try_emplace(keyOf(a, b), false);
  if (isNew)
    known->second =
        surface_.staysInside(points_[std::min(a, b)], points_[std::max(a, b)], kTolerance * size_);
  return known->second;
}

void InsideChords::join(std::uint32_t a, std::uint32_t b) {
  neighbours_[a].push_back(b);
  neighbours_[b].push_back(a);
}

}  // namespace limber
