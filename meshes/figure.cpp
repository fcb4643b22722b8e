// SPDX-License-Identifier: Zlib
#include "figure.h"

#include "surface_net.h"

#include <algorithm>
#include <cmath>

namespace shapes {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

/// A ball drawn along a line, metres. Parts off the plane x = 0 exist twice, left and right.
struct Limb {
  Vector3d from;
  Vector3d to;
  double radius;
};

const std::array<Limb, 5> kLimbs{{
    {{0.0, -0.14, 0.0}, {0.0, 0.02, 0.0}, 0.145},        // body
    {{0.0, 0.235, 0.01}, {0.0, 0.255, 0.01}, 0.135},     // head
    {{0.1, 0.06, 0.0}, {0.4, 0.12, 0.0}, 0.058},         // arm
    {{0.075, -0.22, 0.0}, {0.15, -0.435, 0.02}, 0.065},  // leg
    {{0.06, 0.33, 0.0}, {0.125, 0.45, 0.0}, 0.05},       // ear
}};

/// Distance over which parts melt into each other, metres.
constexpr double kBlend = 0.05;

double distanceToLimb(const Vector3d& p, const Limb& limb) {
  const Vector3d axis = limb.to - limb.from;
  const double along = std::clamp((p - limb.from).dot(axis) / axis.squaredNorm(), 0.0, 1.0);
  return (p - limb.from - along * axis).norm() - limb.radius;
}

/// Polynomial smooth minimum (I. Quilez): the lesser one, rounded off where they differ by less than kBlend.
double smoothMin(double a, double b) {
  const double overlap = std::max(kBlend - std::abs(a - b), 0.0) / kBlend;
  return std::min(a, b) - overlap * overlap * kBlend / 4.0;
}

double figureField(const Vector3d& p) {
  const Vector3d mirrored(std::abs(p.x()), p.y(), p.z());
  double distance = distanceToLimb(mirrored, kLimbs[0]);
  for (std::size_t i = 1; i < kLimbs.size(); ++i)
    distance = smoothMin(distance, distanceToLimb(mirrored, kLimbs[i]));
  return distance;
}

Corner frontCorner(const Vector3d& p) { return {p, Vector2d(p.x() + 0.5, p.y() + 0.5)}; }

/// The quad, split along its shorter diagonal.
void addBestSplit(TriangleSoup& soup, const QuadMesh& mesh, const std::array<std::uint32_t, 4>& quad) {
  const std::array<Corner, 4> c{frontCorner(mesh.vertices[quad[0]]), frontCorner(mesh.vertices[quad[1]]),
                                frontCorner(mesh.vertices[quad[2]]), frontCorner(mesh.vertices[quad[3]])};
  const double ac = (c[0].position - c[2].position).norm(), bd = (c[1].position - c[3].position).norm();
  if (ac <= bd) {
    addQuad(soup, c[0], c[1], c[2], c[3]);
  } else {
    addQuad(soup, c[1], c[2], c[3], c[0]);
  }
}

}  // namespace

TriangleSoup makeFigure() {
  constexpr double kCell = 0.06;
  const CellGrid grid{{-9 * kCell, -10 * kCell, -4 * kCell}, kCell, {18, 20, 8}};
  QuadMesh mesh = buildSurfaceNet(figureField, grid);
  relaxOnSurface(mesh, figureField, 3);
  TriangleSoup soup;
  for (const auto& quad : mesh.quads) addBestSplit(soup, mesh, quad);
  return soup;
}

}  // namespace shapes
