// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/spring_network.h>

#include <array>
#include <cstdint>
#include <vector>

namespace limber {

/// No tetrahedron lies behind a face of the surface.
constexpr std::uint32_t kOutside = 0xffffffffu;

/// The face opposite to a corner, counter-clockwise seen from outside.
Triangle faceOf(const Tetrahedron& tetrahedron, std::size_t corner);

/// For each corner of each tetrahedron the one behind the face opposite to it, or kOutside.
using FaceNeighbours = std::vector<std::array<std::uint32_t, 4>>;
FaceNeighbours findFaceNeighbours(const std::vector<Tetrahedron>& tetrahedra);

/// The faces that only one tetrahedron has, oriented outward, in the order of the tetrahedra.
std::vector<Triangle> surfaceOf(const std::vector<Tetrahedron>& tetrahedra, const FaceNeighbours& neighbours);

/// m^3, above 0 for positive orientation.
double volumeOf(const std::vector<Eigen::Vector3d>& points, const Tetrahedron& tetrahedron);

/// The smallest and the largest angle between two faces, radians.
struct DihedralAngles {
  double smallest = 0.0, largest = 0.0;
};
DihedralAngles dihedralAngles(const std::vector<Eigen::Vector3d>& points, const Tetrahedron& tetrahedron);

}  // namespace limber
