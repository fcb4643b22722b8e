// SPDX-License-Identifier: Zlib
// Integrates stiffness and mass of linear and quadratic tetrahedra.

#include "network/solid_elements.h"

#include "mesh/edges.h"
#include "network/sparse_blocks.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

namespace limber {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Vector3d;

/// Corners of the edges of a tetrahedron.
constexpr std::array<std::array<std::size_t, 2>, 6> kEdgeCorners{
    {{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}}};

/// Volume of a tetrahedron and the gradients (1/m) of its barycentric coordinates.
struct TetrahedronFrame {
  std::array<Vector3d, 4> gradients;
  double volume = 0.0;
};

TetrahedronFrame frameOf(const std::array<Vector3d, 4>& corners) {
  const Vector3d b = corners[1] - corners[0], c = corners[2] - corners[0], d = corners[3] - corners[0];
  const double determinant = b.dot(c.cross(d));
  TetrahedronFrame frame{
      {Vector3d::Zero(), c.cross(d) / determinant, d.cross(b) / determinant, b.cross(c) / determinant},
      determinant / 6.0};
  frame.gradients[0] = -(frame.gradients[1] + frame.gradients[2] + frame.gradients[3]);
  return frame;
}

template <class Nodes>
std::array<Vector3d, 4> cornersOf(const std::vector<Vector3d>& points, const Nodes& nodes) {
  return {points[nodes[0]], points[nodes[1]], points[nodes[2]], points[nodes[3]]};
}

/// Returns the stiffness between two shape functions with these gradients, for each volume:
/// mu (b a^T + a . b I) + lambda a b^T.
Matrix3d stiffnessBlock(const Vector3d& a, const Vector3d& b) {
  return kShearModulus * (a * b.transpose() + b * a.transpose() + Matrix3d(a.dot(b) * Matrix3d::Identity()));
}

/// Adds the blocks of all pairs of an element's nodes. block(i, j) returns the one of its nodes i and j.
template <class Nodes, class Block>
void addPairs(Triplets& triplets, const Nodes& nodes, const Block& block) {
  for (std::size_t i = 0; i < nodes.size(); ++i)
    for (std::size_t j = 0; j < nodes.size(); ++j)
      if (nodes[i] >= nodes[j]) addBlock(triplets, nodes[i], nodes[j], block(i, j));
}

/// Returns the integral of the product of two quadratic shape functions, for a volume of 420.
double quadraticMass(std::size_t i, std::size_t j) {
  if (i > j) std::swap(i, j);
  if (j < 4) return i == j ? 6.0 : 1.0;
  const auto& [c, d] = kEdgeCorners[j - 4];
  if (i < 4) return i == c || i == d ? -4.0 : -6.0;
  const auto& [a, b] = kEdgeCorners[i - 4];
  const int shared = int(a == c) + int(a == d) + int(b == c) + int(b == d);
  return shared == 2 ? 32.0 : shared == 1 ? 16.0 : 8.0;
}

std::array<Vector3d, 10> quadraticGradients(const TetrahedronFrame& frame, const Eigen::Vector4d& position) {
  std::array<Vector3d, 10> gradients;
  for (std::size_t i = 0; i < 4; ++i) gradients[i] = (4.0 * position[Index(i)] - 1.0) * frame.gradients[i];
  for (std::size_t e = 0; e < 6; ++e) {
    const auto [a, b] = kEdgeCorners[e];
    gradients[4 + e] =
        4.0 * (position[Index(a)] * frame.gradients[b] + position[Index(b)] * frame.gradients[a]);
  }
  return gradients;
}

/// Adds the stiffness of an element. Its integrand is of second degree, for which four points are exact.
void addQuadraticStiffness(Triplets& triplets, const std::array<std::uint32_t, 10>& nodes,
                           const TetrahedronFrame& frame) {
  const double near = 0.25 + 0.75 / std::sqrt(5.0), far = (1.0 - near) / 3.0;
  for (Index point = 0; point < 4; ++point) {
    Eigen::Vector4d position = Eigen::Vector4d::Constant(far);
    position[point] = near;
    const std::array<Vector3d, 10> g = quadraticGradients(frame, position);
    addPairs(triplets, nodes, [&](std::size_t i, std::size_t j) -> Matrix3d {
      return 0.25 * frame.volume * stiffnessBlock(g[i], g[j]);
    });
  }
}

}  // namespace

SolidMatrices linearElements(const TetrahedralMesh& mesh) {
  Triplets stiffness, mass;
  for (const Tetrahedron& t : mesh.tetrahedra) {
    const TetrahedronFrame frame = frameOf(cornersOf(mesh.points, t));
    addPairs(stiffness, t, [&](std::size_t i, std::size_t j) -> Matrix3d {
      return frame.volume * stiffnessBlock(frame.gradients[i], frame.gradients[j]);
    });
    addPairs(mass, t, [&](std::size_t i, std::size_t j) -> Matrix3d {
      return frame.volume * (i == j ? 0.1 : 0.05) * Matrix3d::Identity();
    });
  }
  const auto points = static_cast<Index>(mesh.points.size());
  return {sumOf(stiffness, points), sumOf(mass, points)};
}

QuadraticMesh withMiddles(const TetrahedralMesh& mesh) {
  std::vector<Edge> edges;
  for (const Tetrahedron& t : mesh.tetrahedra)
    for (const auto& [a, b] : kEdgeCorners) edges.push_back(edgeBetween(t[a], t[b]));
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  QuadraticMesh quadratic{mesh.points, {}};
  for (const Edge& e : edges) quadratic.nodes.push_back((mesh.points[e[0]] + mesh.points[e[1]]) / 2.0);
  for (const Tetrahedron& t : mesh.tetrahedra) {
    std::array<std::uint32_t, 10> nodes{t[0], t[1], t[2], t[3]};
    for (std::size_t e = 0; e < 6; ++e) {
      const Edge edge = edgeBetween(t[kEdgeCorners[e][0]], t[kEdgeCorners[e][1]]);
      const auto index = std::lower_bound(edges.begin(), edges.end(), edge) - edges.begin();
      nodes[4 + e] = static_cast<std::uint32_t>(mesh.points.size() + std::size_t(index));
    }
    quadratic.tetrahedra.push_back(nodes);
  }
  return quadratic;
}

SolidMatrices quadraticElements(const QuadraticMesh& mesh) {
  Triplets stiffness, mass;
  for (const std::array<std::uint32_t, 10>& nodes : mesh.tetrahedra) {
    const TetrahedronFrame frame = frameOf(cornersOf(mesh.nodes, nodes));
    addQuadraticStiffness(stiffness, nodes, frame);
    addPairs(mass, nodes, [&](std::size_t i, std::size_t j) -> Matrix3d {
      return frame.volume / 420.0 * quadraticMass(i, j) * Matrix3d::Identity();
    });
  }
  const auto points = static_cast<Index>(mesh.nodes.size());
  return {sumOf(stiffness, points), sumOf(mass, points)};
}

std::array<double, 10> quadraticShapes(const Eigen::Vector4d& barycentric) {
  std::array<double, 10> shapes{};
  for (std::size_t i = 0; i < 4; ++i) shapes[i] = barycentric[Index(i)] * (2.0 * barycentric[Index(i)] - 1.0);
  for (std::size_t e = 0; e < 6; ++e)
    shapes[4 + e] = 4.0 * barycentric[Index(kEdgeCorners[e][0])] * barycentric[Index(kEdgeCorners[e][1])];
  return shapes;
}

Eigen::Vector4d barycentricCoordinates(const std::array<Vector3d, 4>& corners, const Vector3d& position) {
  const TetrahedronFrame frame = frameOf(corners);
  Eigen::Vector4d coordinates;
  for (Index i = 0; i < 4; ++i)
    coordinates[i] = (i == 0 ? 1.0 : 0.0) + frame.gradients[std::size_t(i)].dot(position - corners[0]);
  return coordinates;
}

}  // namespace limber
