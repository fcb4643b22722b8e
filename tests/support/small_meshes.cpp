// SPDX-License-Identifier: Zlib
#include "support/small_meshes.h"

#include <cmath>
#include <utility>

namespace small_meshes {
namespace {

using Eigen::Vector3d;

void addTriangle(TriangleMesh& mesh, const Vector3d& a, const Vector3d& b, const Vector3d& c) {
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  mesh.positions.insert(mesh.positions.end(), {a, b, c});
  mesh.triangles.push_back({first, first + 1, first + 2});
}

/// Adds one face of the cube; `axis` is its normal, u and v complete it to a right-handed frame.
void addCubeFace(TriangleMesh& mesh, int n, int axis, int side) {
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  const auto width = static_cast<std::uint32_t>(n + 1);
  for (int v = 0; v <= n; ++v) {
    for (int u = 0; u <= n; ++u) {
      Eigen::Vector3i lattice;  // from -n to n
      lattice[axis] = side * n;
      lattice[(axis + 1) % 3] = side * (2 * u - n);
      lattice[(axis + 2) % 3] = 2 * v - n;
      mesh.positions.emplace_back(lattice.cast<double>() / (2.0 * n));
    }
  }
  for (std::uint32_t v = 0; v + 1 < width; ++v) {
    for (std::uint32_t u = 0; u + 1 < width; ++u) {
      const std::uint32_t corner = first + v * width + u;
      mesh.triangles.push_back({corner, corner + 1, corner + width + 1});
      mesh.triangles.push_back({corner, corner + width + 1, corner + width});
    }
  }
}

void addSplit(TriangleMesh& mesh, const Vector3d& a, const Vector3d& b, const Vector3d& c, int splits) {
  if (splits == 0) {
    addTriangle(mesh, a, b, c);
    return;
  }
  const Vector3d ab = (a + b).normalized(), bc = (b + c).normalized(), ca = (c + a).normalized();
  addSplit(mesh, a, ab, ca, splits - 1);
  addSplit(mesh, b, bc, ab, splits - 1);
  addSplit(mesh, c, ca, bc, splits - 1);
  addSplit(mesh, ab, bc, ca, splits - 1);
}

}  // namespace

TriangleMesh singleTriangle() {
  TriangleMesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  mesh.triangles = {{0, 1, 2}};
  return mesh;
}

TriangleMesh tetrahedron() {
  TriangleMesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  mesh.triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  return mesh;
}

TriangleMesh cube(int n) {
  TriangleMesh mesh;
  for (int axis = 0; axis < 3; ++axis) {
    addCubeFace(mesh, n, axis, 1);
    addCubeFace(mesh, n, axis, -1);
  }
  return mesh;
}

TriangleMesh icosphere(int splits) {
  const double g = (1.0 + std::sqrt(5.0)) / 2.0;
  std::array<Vector3d, 12> p{Vector3d(-1, g, 0), Vector3d(1, g, 0), Vector3d(-1, -g, 0), Vector3d(1, -g, 0),
                             Vector3d(0, -1, g), Vector3d(0, 1, g), Vector3d(0, -1, -g), Vector3d(0, 1, -g),
                             Vector3d(g, 0, -1), Vector3d(g, 0, 1), Vector3d(-g, 0, -1), Vector3d(-g, 0, 1)};
  for (Vector3d& corner : p) corner.normalize();
  constexpr std::array<std::array<std::size_t, 3>, 20> faces{
      {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
       {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
       {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}}};
  TriangleMesh mesh;
  for (const auto& face : faces) addSplit(mesh, p[face[0]], p[face[1]], p[face[2]], splits);
  return mesh;
}

TriangleMesh twoIslands() { return joined(tetrahedron(), moved(tetrahedron(), {5, 0, 0})); }

TriangleMesh nonManifoldEdge() {
  TriangleMesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, -1, 0}};
  mesh.triangles = {{0, 1, 2}, {1, 0, 3}, {0, 1, 4}};
  return mesh;
}

TriangleMesh flippedTriangle() {
  TriangleMesh mesh = tetrahedron();
  std::swap(mesh.triangles[3][1], mesh.triangles[3][2]);
  return mesh;
}

TriangleMesh isolatedVertex() {
  TriangleMesh mesh = singleTriangle();
  mesh.positions.insert(mesh.positions.begin(), Vector3d(9, 9, 9));
  mesh.triangles = {{1, 2, 3}};
  return mesh;
}

TriangleMesh collinearTriangle() {
  TriangleMesh mesh;
  mesh.positions = {{0.1, 0.2, 0.3}, {0.2, 0.4, 0.6}, {0.3, 0.6, 0.9}, {1, 0, 0}};
  mesh.triangles = {{0, 1, 2}, {0, 1, 3}};
  return mesh;
}

TriangleMesh joined(const TriangleMesh& a, const TriangleMesh& b) {
  TriangleMesh mesh = a;
  const auto first = static_cast<std::uint32_t>(a.positions.size());
  mesh.positions.insert(mesh.positions.end(), b.positions.begin(), b.positions.end());
  for (const limber::Triangle& t : b.triangles)
    mesh.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
  return mesh;
}

TriangleMesh moved(TriangleMesh mesh, const Vector3d& displacement, double factor) {
  for (Vector3d& p : mesh.positions) p = factor * p + displacement;
  return mesh;
}

TriangleMesh inverted(TriangleMesh mesh) {
  for (limber::Triangle& t : mesh.triangles) std::swap(t[1], t[2]);
  return mesh;
}

}  // namespace small_meshes
