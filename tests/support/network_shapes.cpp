// SPDX-License-Identifier: Zlib
#include "support/network_shapes.h"

#include "cook/random.h"
#include "support/small_meshes.h"
#include "support/test_shapes.h"

#include <Eigen/Geometry>

#include <cmath>

namespace network_shapes {
namespace {

using Eigen::Vector3d;
using limber::Triangle;

constexpr double kPi = 3.14159265358979323846;

void addQuad(TriangleMesh& mesh, std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
  mesh.triangles.push_back({a, b, c});
  mesh.triangles.push_back({a, c, d});
}

/// Rings of `sides` points about the y axis from y = -length/2 to length/2, quads between them, no caps. Ring
/// r has the points r * sides + s, counter-clockwise seen from +y.
TriangleMesh openTube(std::uint32_t sides, std::uint32_t rings, double radius, double length) {
  TriangleMesh mesh;
  for (std::uint32_t r = 0; r < rings; ++r) {
    for (std::uint32_t s = 0; s < sides; ++s) {
      const double turn = 2.0 * kPi * s / sides;
      mesh.positions.emplace_back(radius * std::sin(turn), length * (double(r) / (rings - 1) - 0.5),
                                  radius * std::cos(turn));
    }
  }
  for (std::uint32_t r = 0; r + 1 < rings; ++r) {
    for (std::uint32_t s = 0; s < sides; ++s) {
      const std::uint32_t a = r * sides + s, b = r * sides + (s + 1) % sides;
      addQuad(mesh, a, b, b + sides, a + sides);
    }
  }
  return mesh;
}

/// Triangles of the first and the last ring's points, all from the ring's first point.
void closeWithFans(TriangleMesh& mesh, std::uint32_t sides) {
  const auto last = static_cast<std::uint32_t>(mesh.positions.size()) - sides;
  for (std::uint32_t s = 1; s + 1 < sides; ++s) {
    mesh.triangles.push_back({0, s + 1, s});
    mesh.triangles.push_back({last, last + s, last + s + 1});
  }
}

void closeWithCentres(TriangleMesh& mesh, std::uint32_t sides) {
  const auto count = static_cast<std::uint32_t>(mesh.positions.size()), last = count - sides;
  mesh.positions.emplace_back(0.0, mesh.positions.front().y(), 0.0);
  mesh.positions.emplace_back(0.0, mesh.positions[last].y(), 0.0);
  for (std::uint32_t s = 0; s < sides; ++s) {
    mesh.triangles.push_back({count, (s + 1) % sides, s});
    mesh.triangles.push_back({count + 1, last + s, last + (s + 1) % sides});
  }
}

/// Every plane through three points with all others behind it holds a triangle.
void addHull(TriangleMesh& mesh) {
  const auto count = static_cast<std::uint32_t>(mesh.positions.size());
  const std::vector<Vector3d>& p = mesh.positions;
  for (std::uint32_t a = 0; a < count; ++a) {
    for (std::uint32_t b = a + 1; b < count; ++b) {
      for (std::uint32_t c = b + 1; c < count; ++c) {
        const Vector3d normal = (p[b] - p[a]).cross(p[c] - p[a]);
        std::uint32_t above = 0, below = 0;
        for (std::uint32_t i = 0; i < count && (above == 0 || below == 0); ++i) {
          if (i == a || i == b || i == c) continue;
          ++((p[i] - p[a]).dot(normal) > 0.0 ? above : below);
        }
        if (above == 0) mesh.triangles.push_back({a, b, c});
        if (below == 0) mesh.triangles.push_back({a, c, b});
      }
    }
  }
}

}  // namespace

TriangleMesh cube8() { return small_meshes::cube(1); }

TriangleMesh cube8Tetrahedral() {
  TriangleMesh mesh;
  for (int i = 0; i < 8; ++i)
    mesh.positions.emplace_back((i & 1) - 0.5, (i >> 1 & 1) - 0.5, (i >> 2 & 1) - 0.5);
  // the tetrahedron 0, 3, 5, 6 and its four corners
  addQuad(mesh, 0, 2, 3, 1);
  addQuad(mesh, 5, 7, 6, 4);
  addQuad(mesh, 0, 1, 5, 4);
  addQuad(mesh, 3, 2, 6, 7);
  addQuad(mesh, 0, 4, 6, 2);
  addQuad(mesh, 3, 7, 5, 1);
  return mesh;
}

TriangleMesh cube26() { return small_meshes::cube(2); }
TriangleMesh cube98() { return small_meshes::cube(4); }

TriangleMesh ico42() { return small_meshes::icosphere(1); }
TriangleMesh ico162() { return small_meshes::icosphere(2); }
TriangleMesh ico642() { return small_meshes::icosphere(3); }

TriangleMesh hull60() {
  limber::Random random(1);
  TriangleMesh mesh;
  for (int i = 0; i < 60; ++i) mesh.positions.push_back(0.5 * random.direction());
  addHull(mesh);
  return mesh;
}

TriangleMesh cyl62() {
  TriangleMesh mesh = openTube(12, 5, 0.25, 1.0);
  closeWithCentres(mesh, 12);
  return mesh;
}

TriangleMesh cyl60() {
  TriangleMesh mesh = openTube(12, 5, 0.25, 1.0);
  closeWithFans(mesh, 12);
  return mesh;
}

TriangleMesh lshape90() { return test_shapes::lShape(); }
TriangleMesh torus128() { return test_shapes::torus(); }
TriangleMesh star162() { return test_shapes::star(); }
TriangleMesh noise162() { return test_shapes::noiseSphere(2); }
TriangleMesh noise642() { return test_shapes::noiseSphere(3); }
TriangleMesh rabbit302() { return test_shapes::rabbit(0.066); }

TriangleMesh tube60() {
  TriangleMesh mesh = openTube(3, 20, 0.05, 1.0);
  closeWithFans(mesh, 3);
  return mesh;
}

TriangleMesh cloth100() {
  constexpr std::uint32_t kPoints = 10;
  TriangleMesh mesh;
  for (std::uint32_t j = 0; j < kPoints; ++j)
    for (std::uint32_t i = 0; i < kPoints; ++i)
      mesh.positions.emplace_back(i / 9.0 - 0.5, 0.0, 0.5 - j / 9.0);
  for (std::uint32_t j = 0; j + 1 < kPoints; ++j) {
    for (std::uint32_t i = 0; i + 1 < kPoints; ++i) {
      const std::uint32_t a = j * kPoints + i;
      addQuad(mesh, a, a + 1, a + kPoints + 1, a + kPoints);
    }
  }
  return mesh;
}

limber::SharedNetwork rope20() {
  limber::RopeSettings settings;
  settings.segments = 19;
  settings.bendingScale = 0.0;
  return *limber::buildRope(settings);
}

const std::vector<NamedShape>& solids() {
  static const std::vector<NamedShape> shapes{{"cube8", cube8},       {"cube8 tetrahedral", cube8Tetrahedral},
                                              {"cube26", cube26},     {"cube98", cube98},
                                              {"ico42", ico42},       {"ico162", ico162},
                                              {"ico642", ico642},     {"hull60", hull60},
                                              {"cyl62", cyl62},       {"cyl60", cyl60},
                                              {"lshape90", lshape90}, {"torus128", torus128},
                                              {"star162", star162},   {"noise162", noise162},
                                              {"noise642", noise642}, {"rabbit302", rabbit302},
                                              {"tube60", tube60}};
  return shapes;
}

limber::SharedNetwork bare(const TriangleMesh& mesh) {
  limber::NetworkSettings settings;
  settings.braces = limber::BraceRule::None;
  settings.braceWeight = 1.0;
  return *limber::buildNetwork(mesh, settings);
}

}  // namespace network_shapes
