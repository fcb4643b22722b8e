// SPDX-License-Identifier: Zlib
#include "support/test_shapes.h"

#include "meshes/shapes.h"
#include "meshes/surface_net.h"
#include "support/constants.h"
#include "support/small_meshes.h"

#include <algorithm>
#include <cmath>

namespace test_shapes {
namespace {

using Eigen::Vector3d;
using limber::test::kPi;

TriangleMesh fromSoup(const shapes::TriangleSoup& soup) {
  TriangleMesh mesh;
  for (const auto& triangle : soup) {
    const auto first = static_cast<std::uint32_t>(mesh.positions.size());
    // rounded as in the mesh files, so that equal corners have equal coordinates
    for (const shapes::Corner& corner : triangle)
      mesh.positions.emplace_back((corner.position.array() * 1e9).round() / 1e9);
    mesh.triangles.push_back({first, first + 1, first + 2});
  }
  return mesh;
}

/// Returns the surface of `field` within a box of 1.2 m around the origin.
TriangleMesh fromField(const shapes::Field& field, double cell) {
  const int cells = 2 * static_cast<int>(std::ceil(0.6 / cell));
  shapes::QuadMesh net = shapes::buildSurfaceNet(
      field, {Vector3d::Constant(-cells / 2 * cell), cell, Eigen::Vector3i::Constant(cells)});
  relaxOnSurface(net, field, 3);
  TriangleMesh mesh;
  mesh.positions = net.vertices;
  for (const auto& q : net.quads) {
    mesh.triangles.push_back({q[0], q[1], q[2]});
    mesh.triangles.push_back({q[0], q[2], q[3]});
  }
  return mesh;
}

/// Returns an approximation of the distance from an ellipsoid.
double ellipsoid(const Vector3d& p, const Vector3d& centre, const Vector3d& radii) {
  const Vector3d q = (p - centre).cwiseQuotient(radii);
  return (q.norm() - 1.0) * radii.minCoeff();
}

double smoothMin(double a, double b, double blend) {
  const double overlap = std::max(blend - std::abs(a - b), 0.0) / blend;
  return std::min(a, b) - overlap * overlap * blend / 4.0;
}

double rabbitField(const Vector3d& p) {
  const Vector3d half(std::abs(p.x()), p.y(), p.z());
  const double body = ellipsoid(p, {0.0, -0.22, 0.0}, {0.22, 0.25, 0.26});
  const double head = ellipsoid(p, {0.0, 0.08, 0.1}, {0.15, 0.15, 0.17});
  const double ear = ellipsoid(half, {0.07, 0.32, 0.06}, {0.045, 0.17, 0.05});
  const double foot = ellipsoid(half, {0.13, -0.43, 0.1}, {0.07, 0.05, 0.14});
  const double trunk = smoothMin(body, head, 0.08);
  return smoothMin(smoothMin(trunk, ear, 0.03), foot, 0.05);
}

/// The field of a ring of mean radius 0.36 with a gap at the top and rounded ends.
double horseshoeField(const Vector3d& p) {
  constexpr double kRing = 0.36, kRod = 0.11, kHalfGap = (0.025 + kRod) / kRing;
  const double angle = std::atan2(p.x(), p.y());  // 0 at the top
  const double along = std::copysign(std::max(std::abs(angle), kHalfGap), angle);
  const Vector3d axis(kRing * std::sin(along), kRing * std::cos(along), 0.0);
  return (p - axis).norm() - kRod;
}

double torusField(const Vector3d& p) { return std::hypot(std::hypot(p.x(), p.y()) - 0.35, p.z()) - 0.13; }

/// A smooth function with values of about -1 to 1: waves in unrelated directions.
double waves(const Vector3d& p) {
  return (std::sin(5.1 * p.x() + 1.3 * p.y() + 0.7) + std::sin(-2.3 * p.x() + 4.9 * p.z() + 1.9) +
          std::sin(4.3 * p.y() - 3.7 * p.z() + 0.2) + std::sin(3.1 * (p.x() + p.y() + p.z()) + kPi / 5.0)) /
         4.0;
}

}  // namespace

TriangleMesh lShape() { return fromSoup(shapes::makeLShape()); }
TriangleMesh torus() { return fromSoup(shapes::makeTorus()); }
TriangleMesh cylinder() { return fromSoup(shapes::makeCylinder()); }
TriangleMesh star() { return fromSoup(shapes::makeStar()); }
TriangleMesh figure() { return fromSoup(shapes::makeFigure()); }

TriangleMesh noiseSphere(int splits) {
  TriangleMesh mesh = small_meshes::icosphere(splits);
  for (Vector3d& p : mesh.positions) p *= 0.5 * (1.0 + 0.33 * waves(p));
  return mesh;
}

TriangleMesh rabbit(double cell) { return fromField(rabbitField, cell); }
TriangleMesh horseshoe(double cell) { return fromField(horseshoeField, cell); }
TriangleMesh roundTorus(double cell) { return fromField(torusField, cell); }

}  // namespace test_shapes
