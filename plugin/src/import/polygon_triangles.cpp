// SPDX-License-Identifier: Zlib
#include "import/polygon_triangles.h"

#include <Eigen/Geometry>

#include <cstddef>
#include <numeric>

namespace limber {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Ring = std::vector<std::uint32_t>;  ///< corners not yet clipped off, counter-clockwise

/// Clipping takes up to the third power of the number of corners; above this, polygons are taken for convex.
constexpr std::size_t kMostCornersToClip = 1000;

/// The sum of the corner fans' area vectors, twice the area (Newell's method); also right for concave
/// polygons.
Vector3d areaVector(const std::vector<Vector3d>& corners) {
  Vector3d sum = Vector3d::Zero();
  for (std::size_t i = 1; i + 1 < corners.size(); ++i) {
    sum += (corners[i] - corners[0]).cross(corners[i + 1] - corners[0]);
  }
  return sum;
}

/// The polygon seen along the axis nearest to its normal, from the side where it is counter-clockwise.
std::vector<Vector2d> project(const std::vector<Vector3d>& corners) {
  const Vector3d normal = areaVector(corners);
  Eigen::Index axis = 0;
  normal.cwiseAbs().maxCoeff(&axis);
  const bool fromAbove = normal[axis] >= 0.0;
  const Eigen::Index u = (axis + (fromAbove ? 1 : 2)) % 3, v = (axis + (fromAbove ? 2 : 1)) % 3;
  std::vector<Vector2d> points;
  points.reserve(corners.size());
  for (const Vector3d& corner : corners) points.emplace_back(corner[u], corner[v]);
  return points;
}

/// Above 0 when c lies to the left of the line from a to b.
double side(const Vector2d& a, const Vector2d& b, const Vector2d& c) {
  const Vector2d ab = b - a, ac = c - a;
  return ab.x() * ac.y() - ab.y() * ac.x();
}

/// Whether p lies in the triangle or on its border, but not in a corner.
bool blocks(const Vector2d& p, const Vector2d& a, const Vector2d& b, const Vector2d& c) {
  if (p == a || p == b || p == c) return false;
  return side(a, b, p) >= 0.0 && side(b, c, p) >= 0.0 && side(c, a, p) >= 0.0;
}

Triangle cornerAt(const Ring& ring, std::size_t place) {
  return {ring[(place + ring.size() - 1) % ring.size()], ring[place], ring[(place + 1) % ring.size()]};
}

/// An ear is a corner that points outward and whose triangle holds no other corner.
bool isEar(const Ring& ring, std::size_t place, const std::vector<Vector2d>& points) {
  const Triangle t = cornerAt(ring, place);
  const Vector2d &a = points[t[0]], &b = points[t[1]], &c = points[t[2]];
  if (!(side(a, b, c) > 0.0)) return false;
  for (const std::uint32_t other : ring) {
    if (blocks(points[other], a, b, c)) return false;
  }
  return true;
}

/// Place 1 comes first, so that a convex polygon becomes a fan around corner 0. Simple polygons always have
/// an ear (G. Meisters 1975); others lose that corner anyway.
std::size_t findEar(const Ring& ring, const std::vector<Vector2d>& points) {
  for (std::size_t i = 1; i <= ring.size(); ++i) {
    if (isEar(ring, i % ring.size(), points)) return i % ring.size();
  }
  return 1;
}

}  // namespace

std::vector<Triangle> splitPolygon(const std::vector<Vector3d>& corners) {
  const std::vector<Vector2d> points = project(corners);
  Ring ring(corners.size());
  std::iota(ring.begin(), ring.end(), 0u);
  std::vector<Triangle> triangles;
  if (ring.size() > kMostCornersToClip) {
    for (std::size_t i = 1; i + 1 < ring.size(); ++i) triangles.push_back({ring[0], ring[i], ring[i + 1]});
    return triangles;
  }
  while (ring.size() > 3) {
    const std::size_t ear = findEar(ring, points);
    triangles.push_back(cornerAt(ring, ear));
    ring.erase(ring.begin() + static_cast<std::ptrdiff_t>(ear));
  }
  triangles.push_back({ring[0], ring[1], ring[2]});
  return triangles;
}

}  // namespace limber
