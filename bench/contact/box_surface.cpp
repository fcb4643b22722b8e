// SPDX-License-Identifier: Zlib
#include "contact/box_surface.h"

#include <array>
#include <cstdint>

namespace limber::bench {
namespace {

/// Returns the index of a point. Neighbours along x, axis 0, have the largest difference of indices.
std::uint32_t indexOf(const std::array<int, 3>& cell, int side) {
  return static_cast<std::uint32_t>((cell[0] * side + cell[1]) * side + cell[2]);
}

/// Returns the right-handed quad in layer `at` of an axis. Its lowest corner is (i, j) along the other two.
std::array<std::uint32_t, 4> quadOf(std::size_t axis, int at, int i, int j, int side) {
  const std::size_t u = (axis + 1) % 3, v = (axis + 2) % 3;
  std::array<std::uint32_t, 4> quad{};
  const int offsets[4][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  for (std::size_t k = 0; k < 4; ++k) {
    std::array<int, 3> cell{};
    cell[axis] = at;
    cell[u] = i + offsets[k][0];
    cell[v] = j + offsets[k][1];
    quad[k] = indexOf(cell, side);
  }
  return quad;
}

}  // namespace

std::vector<Triangle> boxSurface(int side) {
  std::vector<Triangle> triangles;
  for (std::size_t axis = 0; axis < 3; ++axis)
    for (int i = 0; i + 1 < side; ++i)
      for (int j = 0; j + 1 < side; ++j) {
        const auto far = quadOf(axis, side - 1, i, j, side), near = quadOf(axis, 0, i, j, side);
        triangles.insert(triangles.end(), {{far[0], far[1], far[2]}, {far[0], far[2], far[3]}});
        triangles.insert(triangles.end(), {{near[0], near[2], near[1]}, {near[0], near[3], near[2]}});
      }
  return triangles;
}

}  // namespace limber::bench
