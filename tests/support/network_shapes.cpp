// SPDX-License-Identifier: Zlib
#include "support/network_shapes.h"

#include "mesh/random.h"
#include "support/constants.h"
#include "support/small_meshes.h"
#include "support/test_shapes.h"

#include <Eigen/Geometry>

#include <limber/mesh.h>

#include <cmath>
#include <functional>
#include <map>

namespace network_shapes {
namespace {

using Eigen::Vector3d;
using limber::Triangle;
using limber::test::kPi;

void addQuad(TriangleMesh& mesh, std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
  mesh.triangles.push_back({a, b, c});
  mesh.triangles.push_back({a, c, d});
}

using Cell = Eigen::Vector3i;

/// Returns the surface between full and empty cells of a lattice, two triangles for each face of a cell,
/// scaled to a largest extent of 1. `flipsDiagonal` selects the diagonal of a face by its cell and axis.
TriangleMesh cellSurface(const Cell& size, const std::function<bool(const Cell&)>& isFull,
                         const std::function<bool(const Cell&, int)>& flipsDiagonal) {
  TriangleMesh mesh;
  std::map<std::array<int, 3>, std::uint32_t> indices;
  const auto pointAt = [&](const Cell& node) {
    const auto [entry, isNew] =
        indices.try_emplace({node[0], node[1], node[2]}, static_cast<std::uint32_t>(mesh.positions.size()));
    if (isNew)
      mesh.positions.emplace_back((node.cast<double>() - 0.5 * size.cast<double>()) / size.maxCoeff());
    return entry->second;
  };
  const auto covers = [&](const Cell& c) {
    return c.minCoeff() >= 0 && ((size - c).array() > 0).all() && isFull(c);
  };
  const auto addFace = [&](const Cell& cell, int axis, int side) {
    const Cell corner = cell + side * Cell::Unit(axis);
    const Cell u = Cell::Unit((axis + 1) % 3), w = Cell::Unit((axis + 2) % 3);
    std::array<std::uint32_t, 4> c{pointAt(corner), pointAt(corner + u), pointAt(corner + u + w),
                                   pointAt(corner + w)};
    if (side == 0) std::swap(c[1], c[3]);
    const std::size_t first = flipsDiagonal(cell, axis) ? 1 : 0;
    addQuad(mesh, c[first], c[first + 1], c[first + 2], c[(first + 3) % 4]);
  };
  for (int x = 0; x < size.x(); ++x)
    for (int y = 0; y < size.y(); ++y)
      for (int z = 0; z < size.z(); ++z)
        for (int face = 0; covers({x, y, z}) && face < 6; ++face)
          if (!covers(Cell(x, y, z) + (face % 2 ? 1 : -1) * Cell::Unit(face / 2)))
            addFace({x, y, z}, face / 2, face % 2);
  return mesh;
}

/// Returns a cube with n x n cells on each face; neighbouring cells have different diagonals.
TriangleMesh alternatingCube(int n) {
  return cellSurface(
      Cell::Constant(n), [](const Cell&) { return true; },
      [](const Cell& c, int axis) { return (c[(axis + 1) % 3] + c[(axis + 2) % 3]) % 2 != 0; });
}

/// Returns rings of `sides` points about the y axis from y = -length/2 to length/2, joined by quads, without
/// caps. Ring r has the points r * sides + s, counter-clockwise seen from +y.
TriangleMesh openTube(std::uint32_t sides, std::uint32_t rings, double radius, double length) {
  TriangleMesh mesh;
  for (std::uint32_t r = 0; r < rings; ++r) {
    for (std::uint32_t s = 0; s < sides; ++s) {
      const double angle = 2.0 * kPi * s / sides;
      mesh.positions.emplace_back(radius * std::sin(angle), length * (double(r) / (rings - 1) - 0.5),
                                  radius * std::cos(angle));
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

/// Closes the first and the last ring with triangles that share the ring's first point.
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

/// Adds a triangle for every three points whose plane has all other points on one side.
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

TriangleMesh cube8() { return alternatingCube(1); }
TriangleMesh cube8Tetrahedral() { return small_meshes::cube(1); }
TriangleMesh cube26() { return alternatingCube(2); }
TriangleMesh cube98() { return alternatingCube(4); }

TriangleMesh ico42() { return small_meshes::icosphere(1); }
TriangleMesh ico162() { return small_meshes::icosphere(2); }
TriangleMesh ico642() { return small_meshes::icosphere(3); }

TriangleMesh hull60() {
  limber::Random random(2);
  TriangleMesh mesh;
  for (int i = 0; i < 60; ++i) mesh.positions.push_back(0.5 * random.direction());
  addHull(mesh);
  return mesh;
}

TriangleMesh cyl62() {
  TriangleMesh mesh = openTube(12, 5, 0.315, 1.0);
  closeWithCentres(mesh, 12);
  return mesh;
}

TriangleMesh cyl60() {
  TriangleMesh mesh = openTube(12, 5, 0.315, 1.0);
  closeWithFans(mesh, 12);
  return mesh;
}

TriangleMesh lshape90() {
  return cellSurface(
      {6, 6, 2}, [](const Cell& c) { return c.x() < 2 || c.y() < 2; },
      [](const Cell& c, int) { return c.sum() % 2 != 0; });
}

TriangleMesh torus128() {
  constexpr std::uint32_t kSegments = 16, kSides = 8;
  constexpr double kRing = 0.5 / 1.4, kTube = 0.4 * kRing;
  TriangleMesh mesh;
  for (std::uint32_t i = 0; i < kSegments; ++i) {
    for (std::uint32_t j = 0; j < kSides; ++j) {
      const double angle = 2.0 * kPi * i / kSegments, tilt = 2.0 * kPi * j / kSides;
      const double radius = kRing + kTube * std::cos(tilt);
      mesh.positions.emplace_back(radius * std::cos(angle), radius * std::sin(angle), kTube * std::sin(tilt));
      const std::uint32_t segment = i * kSides, next = (i + 1) % kSegments * kSides, up = (j + 1) % kSides;
      addQuad(mesh, segment + j, next + j, next + up, segment + up);
    }
  }
  return mesh;
}

TriangleMesh star162() { return test_shapes::star(); }
TriangleMesh noise162() { return test_shapes::noiseSphere(2); }
TriangleMesh noise642() { return test_shapes::noiseSphere(3); }
TriangleMesh rabbit302() { return *limber::simplify(test_shapes::rabbit(0.03), 302); }

TriangleMesh tube60() {
  TriangleMesh mesh = openTube(3, 20, 0.0421, 1.0);
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
      if ((i + j) % 2 == 0)
        addQuad(mesh, a, a + 1, a + kPoints + 1, a + kPoints);
      else
        addQuad(mesh, a + 1, a + kPoints + 1, a + kPoints, a);
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
