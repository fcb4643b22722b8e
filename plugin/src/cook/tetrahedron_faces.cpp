// SPDX-License-Identifier: Zlib
#include "cook/tetrahedron_faces.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <utility>

namespace limber {
namespace {

using Eigen::Vector3d;

/// Times twice the area, pointing outward.
Vector3d faceNormal(const std::vector<Vector3d>& points, const Tetrahedron& t, std::size_t corner) {
  const Triangle f = faceOf(t, corner);
  return (points[f[1]] - points[f[0]]).cross(points[f[2]] - points[f[0]]);
}

}  // namespace

Triangle faceOf(const Tetrahedron& t, std::size_t corner) {
  switch (corner) {
    case 0:
      return {t[1], t[2], t[3]};
    case 1:
      return {t[0], t[3], t[2]};
    case 2:
      return {t[0], t[1], t[3]};
    default:
      return {t[0], t[2], t[1]};
  }
}

FaceNeighbours findFaceNeighbours(const std::vector<Tetrahedron>& tetrahedra) {
  std::vector<std::pair<Triangle, std::uint32_t>> faces;  // sorted corners; 4 x tetrahedron + corner
  faces.reserve(4 * tetrahedra.size());
  for (std::uint32_t t = 0; t < tetrahedra.size(); ++t)
    for (std::uint32_t corner = 0; corner < 4; ++corner) {
      Triangle face = faceOf(tetrahedra[t], corner);
      std::sort(face.begin(), face.end());
      faces.emplace_back(face, 4 * t + corner);
    }
  std::sort(faces.begin(), faces.end());
  FaceNeighbours neighbours(tetrahedra.size(), {kOutside, kOutside, kOutside, kOutside});
  for (std::size_t i = 1; i < faces.size(); ++i) {
    if (faces[i].first != faces[i - 1].first) continue;
    const std::uint32_t a = faces[i - 1].second, b = faces[i].second;
    neighbours[a / 4][a % 4] = b / 4;
    neighbours[b / 4][b % 4] = a / 4;
  }
  return neighbours;
}

std::vector<Triangle> surfaceOf(const std::vector<Tetrahedron>& tetrahedra,
                                const FaceNeighbours& neighbours) {
  std::vector<Triangle> surface;
  for (std::size_t t = 0; t < tetrahedra.size(); ++t)
    for (std::size_t corner = 0; corner < 4; ++corner)
      if (neighbours[t][corner] == kOutside) surface.push_back(faceOf(tetrahedra[t], corner));
  return surface;
}

double volumeOf(const std::vector<Vector3d>& points, const Tetrahedron& t) {
  const Vector3d& a = points[t[0]];
  return (points[t[1]] - a).dot((points[t[2]] - a).cross(points[t[3]] - a)) / 6.0;
}

DihedralAngles dihedralAngles(const std::vector<Vector3d>& points, const Tetrahedron& t) {
  std::array<Vector3d, 4> normals;
  for (std::size_t i = 0; i < 4; ++i) normals[i] = faceNormal(points, t, i).normalized();
  DihedralAngles angles{3.2, 0.0};
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t j = i + 1; j < 4; ++j) {
      const double angle = std::acos(std::clamp(-normals[i].dot(normals[j]), -1.0, 1.0));
      angles.smallest = std::min(angles.smallest, angle);
      angles.largest = std::max(angles.largest, angle);
    }
  return angles;
}

}  // namespace limber
