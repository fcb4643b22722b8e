// SPDX-License-Identifier: Zlib
// Declares the edges of triangle meshes, their connected components and the defects of edges, and texts about
// counts, numbers and indices.
#pragma once

#include <limber/mesh.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <numeric>
#include <string>
#include <vector>

namespace limber {

/// Two point indices, the smaller one first.
using Edge = std::array<std::uint32_t, 2>;

inline Edge edgeBetween(std::uint32_t a, std::uint32_t b) { return {std::min(a, b), std::max(a, b)}; }

/// Returns the edges of the triangles, sorted, each once. Corners of a triangle must differ.
std::vector<Edge> uniqueEdges(const std::vector<Triangle>& triangles);

/// Numbers of edges that a closed, oriented surface does not have; see MeshReport.
struct EdgeDefects {
  std::size_t open = 0;
  std::size_t nonManifold = 0;
  std::size_t inconsistent = 0;

  bool none() const { return open + nonManifold + inconsistent == 0; }
};

EdgeDefects findEdgeDefects(const std::vector<Triangle>& triangles);

/// Sets the numbers of defective edges in the report of a mesh with these triangles.
void setEdgeDefects(MeshReport& report, const std::vector<Triangle>& triangles);

/// Returns for each point the indices of the triangles or tetrahedra of which it is a corner, ascending.
template <class Corners>
std::vector<std::vector<std::uint32_t>> elementsOfPoints(std::size_t points,
                                                         const std::vector<Corners>& all) {
  std::vector<std::vector<std::uint32_t>> elements(points);
  for (std::uint32_t i = 0; i < all.size(); ++i)
    for (const std::uint32_t corner : all[i]) elements[corner].push_back(i);
  return elements;
}

/// Sets of indices that can be joined. The smallest member of a set, its root, identifies it.
class DisjointSets {
 public:
  explicit DisjointSets(std::size_t count) : parent_(count) {
    std::iota(parent_.begin(), parent_.end(), std::uint32_t{0});
  }

  std::uint32_t root(std::uint32_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void join(std::uint32_t i, std::uint32_t j) {
    i = root(i), j = root(j);
    parent_[std::max(i, j)] = std::min(i, j);
  }

 private:
  std::vector<std::uint32_t> parent_;
};

/// Connected components of a surface. They share no point.
struct SurfaceComponents {
  std::size_t count = 0;
  std::vector<std::uint32_t> ofTriangle;  ///< #triangles, numbered in the order of their first triangles
};

SurfaceComponents findComponents(std::size_t points, const std::vector<Triangle>& triangles);

// --- texts ---

/// Returns "1 vertex", "2 vertices".
inline std::string counted(std::size_t count, const char* one, const char* many) {
  return std::to_string(count) + " " + (count == 1 ? one : many);
}

/// Returns "0.0123", "1.23e+06".
inline std::string inThreeDigits(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", value);
  return text;
}

/// Returns "spring 3".
inline std::string numbered(const char* what, std::size_t index) {
  return what + (" " + std::to_string(index));
}

/// Describes the first corner of triangles or tetrahedra that is not below `count`, such as "triangle 17 uses
/// vertex 900 of 812"; empty if there is none.
template <class Corners>
std::string checkCorners(const std::vector<Corners>& all, std::size_t count, const char* name,
                         const char* cornerName) {
  for (std::size_t i = 0; i < all.size(); ++i)
    for (const std::uint32_t corner : all[i])
      if (corner >= count)
        return numbered(name, i) + " uses " + numbered(cornerName, corner) + " of " + std::to_string(count);
  return {};
}

}  // namespace limber
