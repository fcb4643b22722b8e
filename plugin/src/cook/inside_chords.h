// SPDX-License-Identifier: Zlib
#pragma once

#include "mesh/edges.h"
#include "mesh/triangle_bvh.h"

#include <cstdint>
#include <unordered_map>
#include <vector>

namespace limber {

/// Which pairs of points of a surface may still be joined by a brace: those without a spring whose chord
/// stays inside. Asks the surface about a pair once at most.
class InsideChords {
 public:
  /// Triangles outwards; `edges` are the springs there are.
  InsideChords(const std::vector<Eigen::Vector3d>& points, const std::vector<Triangle>& triangles,
               const std::vector<Edge>& edges);

  const TriangleBvh& surface() const { return surface_; }
  double size() const { return size_; }  ///< m, the largest extent
  const std::vector<std::uint32_t>& neighbours(std::uint32_t point) const { return neighbours_[point]; }

  bool joined(std::uint32_t a, std::uint32_t b) const;
  bool allowed(std::uint32_t a, std::uint32_t b);
  void join(std::uint32_t a, std::uint32_t b);

 private:
  std::vector<Eigen::Vector3d> points_;
  double size_;
  TriangleBvh surface_;
  std::vector<std::vector<std::uint32_t>> neighbours_;  ///< #points, along springs
  std::unordered_map<std::uint64_t, bool> inside_;      ///< of pairs asked for so far
};

}  // namespace limber
