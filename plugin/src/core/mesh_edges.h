// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/triangle_mesh.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace limber {

/// Two point indices, the smaller one first.
using Edge = std::array<std::uint32_t, 2>;

/// The edges of the triangles, sorted, each once. Corners of a triangle must differ.
std::vector<Edge> uniqueEdges(const std::vector<Triangle>& triangles);

/// The edges that a closed, oriented surface does not have; see MeshReport.
struct EdgeDefects {
  std::size_t open = 0;
  std::size_t nonManifold = 0;
  std::size_t inconsistent = 0;
};

EdgeDefects findEdgeDefects(const std::vector<Triangle>& triangles);

}  // namespace limber
