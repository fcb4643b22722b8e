// SPDX-License-Identifier: Zlib
#include "support/networks.h"

#include "support/small_meshes.h"

#include <limber/network_builder.h>

#include <array>
#include <cmath>
#include <map>
#include <set>
#include <utility>

namespace limber::test {
namespace {

SharedNetwork network(NetworkKind kind, std::vector<Eigen::Vector3d> points,
                      const std::vector<std::pair<std::uint32_t, std::uint32_t>>& springs) {
  auto made = std::make_shared<SpringNetwork>();
  made->kind = kind;
  made->massFractions.assign(points.size(), 1.0 / static_cast<double>(points.size()));
  made->restPoints = std::move(points);
  for (const auto& [a, b] : springs) made->springs.push_back({a, b, SpringKind::Structural, 1.0});
  return made;
}

/// Returns the result of `build` for this mesh and key. It builds a network at the first call only.
template <typename Build>
SharedNetwork builtOnce(const TriangleMesh& mesh, std::uint32_t key, const Build& build) {
  static std::map<std::vector<double>, SharedNetwork> networks;
  std::vector<double> values{static_cast<double>(key)};
  for (const Eigen::Vector3d& p : mesh.positions) values.insert(values.end(), p.data(), p.data() + 3);
  for (const Triangle& t : mesh.triangles)
    for (const std::uint32_t corner : t) values.push_back(corner);
  SharedNetwork& network = networks[values];
  if (!network) network = build();
  return network;
}

SharedNetwork cube(double longestSpring) {
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < 8; ++i) points.emplace_back((i & 1) - 0.5, (i >> 1 & 1) - 0.5, (i >> 2 & 1) - 0.5);
  std::vector<std::pair<std::uint32_t, std::uint32_t>> springs;
  for (std::uint32_t a = 0; a < 8; ++a)
    for (std::uint32_t b = a + 1; b < 8; ++b)
      if ((points[a] - points[b]).norm() < longestSpring) springs.emplace_back(a, b);
  return network(NetworkKind::Solid, points, springs);
}

}  // namespace

SharedNetwork pairNetwork() { return network(NetworkKind::Rope, {{0, 0, 0}, {1, 0, 0}}, {{0, 1}}); }

SharedNetwork chainNetwork(int links) {
  std::vector<Eigen::Vector3d> points;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> springs;
  for (int i = 0; i <= links; ++i) points.emplace_back(0, -static_cast<double>(i) / links, 0);
  for (std::uint32_t i = 0; i < static_cast<std::uint32_t>(links); ++i) springs.emplace_back(i, i + 1);
  return network(NetworkKind::Rope, points, springs);
}

SharedNetwork cubeNetwork() { return cube(1.5); }
SharedNetwork fullCubeNetwork() { return cube(2.0); }

namespace {

/// Returns a network with springs along all edges of the tetrahedra.
SharedNetwork tetrahedralNetwork(const std::vector<Eigen::Vector3d>& points,
                                 const std::vector<Tetrahedron>& tetrahedra) {
  auto network = std::make_shared<SpringNetwork>();
  network->restPoints = points;
  network->massFractions.assign(points.size(), 1.0 / static_cast<double>(points.size()));
  network->tetrahedra = tetrahedra;
  std::set<std::pair<std::uint32_t, std::uint32_t>> edges;
  for (const Tetrahedron& t : tetrahedra)
    for (std::size_t i = 0; i < 4; ++i)
      for (std::size_t j = 0; j < i; ++j) edges.insert(std::minmax(t[i], t[j]));
  for (const auto& [a, b] : edges) network->springs.push_back({a, b, SpringKind::Structural, 1.0});
  return network;
}

}  // namespace

SharedNetwork tetrahedronNetwork() {
  const double r = std::sqrt(0.125);
  return tetrahedralNetwork({{r, r, r}, {r, -r, -r}, {-r, r, -r}, {-r, -r, r}}, {{0, 2, 1, 3}});
}

namespace {

/// The tetrahedra of a cube with corner (x, y, z) at index x + 2 y + 4 z. Each follows a path from corner 0
/// to corner 7 along the three axes, in one of their six orders. Those of odd order have two corners swapped,
/// for a positive volume.
constexpr std::array<Tetrahedron, 6> kInCube = {
    {{0, 1, 3, 7}, {0, 2, 6, 7}, {0, 4, 5, 7}, {0, 3, 2, 7}, {0, 6, 4, 7}, {0, 5, 1, 7}}};

}  // namespace

SharedNetwork tetrahedralCubeNetwork() {
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < 8; ++i) points.emplace_back((i & 1) - 0.5, (i >> 1 & 1) - 0.5, (i >> 2) - 0.5);
  return tetrahedralNetwork(points, {kInCube.begin(), kInCube.end()});
}

SharedNetwork tetrahedralBlockNetwork(int nx, int ny, int nz) {
  const auto number = [&](int x, int y, int z) {
    return static_cast<std::uint32_t>((z * (ny + 1) + y) * (nx + 1) + x);
  };
  std::vector<Eigen::Vector3d> points;
  std::vector<Tetrahedron> tetrahedra;
  for (int z = 0; z <= nz; ++z)
    for (int y = 0; y <= ny; ++y)
      for (int x = 0; x <= nx; ++x) {
        points.emplace_back(x, y, z);
        if (x == nx || y == ny || z == nz) continue;
        for (Tetrahedron t : kInCube) {
          for (std::uint32_t& corner : t)
            corner = number(x + int(corner & 1), y + int(corner >> 1 & 1), z + int(corner >> 2));
          tetrahedra.push_back(t);
        }
      }
  return tetrahedralNetwork(points, tetrahedra);
}

SharedNetwork closedCubeNetwork() {
  NetworkSettings settings;
  settings.braces = BraceRule::EqualLength;
  settings.braceWeight = 1.0;
  return *buildNetwork(small_meshes::cube(), settings);
}

SharedNetwork clothNetwork(std::uint32_t columns, std::uint32_t rows, double width, double depth) {
  ClothSettings settings;
  settings.width = width;
  settings.depth = depth;
  settings.columns = columns;
  settings.rows = rows;
  return *buildCloth(settings);
}

SharedNetwork squareCloth(std::uint32_t cells, double width) {
  return clothNetwork(cells, cells, width, width);
}

SharedNetwork ropeNetwork(std::uint32_t segments, double length) {
  RopeSettings settings;
  settings.segments = segments;
  settings.length = length;
  return *buildRope(settings);
}

SharedNetwork solidNetwork(const TriangleMesh& mesh, std::uint32_t points) {
  MaterialMesh settings;
  settings.points = points;
  return builtOnce(mesh, points, [&] { return *buildMaterialNetwork(mesh, settings); });
}

SharedNetwork bracedNetwork(const TriangleMesh& mesh) {
  return builtOnce(mesh, 0, [&] { return *buildNetwork(mesh); });
}

}  // namespace limber::test
