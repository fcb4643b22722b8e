// SPDX-License-Identifier: Zlib
#include "cook/edge_collapse.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

namespace limber {
namespace {

using Eigen::Vector3d;

/// Points of a patch pull at its new point with this part of the weight of its planes: enough to spread
/// points evenly where the surface is flat, too little to pull them below it where it is curved.
constexpr double kPointWeight = 1e-3;
/// Borders are held by planes through them across the surface, of this weight times their squared length.
constexpr double kBorderWeight = 10.0;
/// Cosine of the largest turn of a triangle in one collapse.
constexpr double kLargestFaceTurn = 0.3;
/// The least quality of a new triangle,  4 sqrt(3) area / sum of squared sides  (1: equilateral), unless the
/// old one was worse.
constexpr double kLeastQuality = 0.15;

bool contains(const Triangle& t, std::uint32_t point) {
  return t[0] == point || t[1] == point || t[2] == point;
}

Vector3d areaVector(const Vector3d& a, const Vector3d& b, const Vector3d& c) {
  return 0.5 * (b - a).cross(c - a);
}

Vector3d areaVector(const CollapsibleSurface& surface, const Triangle& t) {
  return areaVector(surface.points[t[0]], surface.points[t[1]], surface.points[t[2]]);
}

double quality(const Vector3d& a, const Vector3d& b, const Vector3d& c) {
  const double sides = (b - a).squaredNorm() + (c - b).squaredNorm() + (a - c).squaredNorm();
  return sides > 0.0 ? 4.0 * std::sqrt(3.0) * areaVector(a, b, c).norm() / sides : 0.0;
}

std::vector<std::uint32_t> sharedTriangles(const CollapsibleSurface& surface, std::uint32_t a,
                                           std::uint32_t b) {
  std::vector<std::uint32_t> shared;
  std::set_intersection(surface.trianglesOf[a].begin(), surface.trianglesOf[a].end(),
                        surface.trianglesOf[b].begin(), surface.trianglesOf[b].end(),
                        std::back_inserter(shared));
  return shared;
}

void addTriangleQuadrics(CollapsibleSurface& surface, const Triangle& t) {
  const Vector3d vector = areaVector(surface, t);
  const double area = vector.norm();
  if (area == 0.0) return;
  const Quadric plane = planeQuadric(vector / area, surface.points[t[0]], area / 3.0);
  for (const std::uint32_t corner : t) {
    surface.quadrics[corner] += plane;
    surface.quadrics[corner] += pointQuadric(surface.points[corner], kPointWeight * area / 3.0);
  }
}

void addBorderQuadric(CollapsibleSurface& surface, std::uint32_t a, std::uint32_t b, const Triangle& t) {
  const Vector3d side = surface.points[b] - surface.points[a];
  const Vector3d across = side.cross(areaVector(surface, t)).normalized();
  const Quadric plane = planeQuadric(across, surface.points[a], kBorderWeight * side.squaredNorm());
  surface.quadrics[a] += plane;
  surface.quadrics[b] += plane;
}

/// Marks borders and points whose triangles are not one fan, and holds the borders in place.
void inspectEdges(CollapsibleSurface& surface, std::uint32_t a) {
  std::size_t borders = 0;
  for (const std::uint32_t b : neighboursOf(surface, a)) {
    const std::vector<std::uint32_t> shared = sharedTriangles(surface, a, b);
    if (shared.size() > 2) surface.fixed[a] = 1;
    if (shared.size() != 1) continue;
    ++borders;
    surface.onBorder[a] = 1;
    if (a < b) addBorderQuadric(surface, a, b, surface.triangles[shared[0]]);
  }
  if (borders > 2) surface.fixed[a] = 1;
}

/// The neighbours that both have must be the third corners of the triangles between them, and these must keep
/// enough triangles: three within the surface, one on its border.
bool linkAllows(const CollapsibleSurface& surface, std::uint32_t a, std::uint32_t b) {
  const std::vector<std::uint32_t> shared = sharedTriangles(surface, a, b);
  if (shared.empty() || shared.size() > 2) return false;
  if (surface.onBorder[a] && surface.onBorder[b] && shared.size() == 2) return false;
  const std::vector<std::uint32_t> ofA = neighboursOf(surface, a), ofB = neighboursOf(surface, b);
  std::vector<std::uint32_t> common;
  std::set_intersection(ofA.begin(), ofA.end(), ofB.begin(), ofB.end(), std::back_inserter(common));
  if (common.size() != shared.size()) return false;
  return std::all_of(common.begin(), common.end(), [&](std::uint32_t apex) {
    return surface.trianglesOf[apex].size() > (surface.onBorder[apex] ? 1u : 3u);
  });
}

/// For the triangles of `moved` that stay.
bool shapeAllows(const CollapsibleSurface& surface, std::uint32_t moved, std::uint32_t other,
                 const Vector3d& place) {
  for (const std::uint32_t i : surface.trianglesOf[moved]) {
    const Triangle& t = surface.triangles[i];
    if (contains(t, other)) continue;
    std::array<Vector3d, 3> before, after;
    for (std::size_t c = 0; c < 3; ++c) {
      before[c] = surface.points[t[c]];
      after[c] = t[c] == moved ? place : before[c];
    }
    const Vector3d was = areaVector(before[0], before[1], before[2]);
    const Vector3d is = areaVector(after[0], after[1], after[2]);
    if (was.dot(is) <= kLargestFaceTurn * was.norm() * is.norm()) return false;
    const double least = std::min(kLeastQuality, quality(before[0], before[1], before[2]));
    if (quality(after[0], after[1], after[2]) < least) return false;
  }
  return true;
}

}  // namespace

std::vector<std::uint32_t> neighboursOf(const CollapsibleSurface& surface, std::uint32_t point) {
  std::vector<std::uint32_t> neighbours;
  for (const std::uint32_t i : surface.trianglesOf[point]) {
    for (const std::uint32_t corner : surface.triangles[i]) {
      if (corner != point) neighbours.push_back(corner);
    }
  }
  std::sort(neighbours.begin(), neighbours.end());
  neighbours.erase(std::unique(neighbours.begin(), neighbours.end()), neighbours.end());
  return neighbours;
}

CollapsibleSurface makeCollapsible(std::vector<Vector3d> points, std::vector<Triangle> triangles) {
  CollapsibleSurface surface;
  surface.points = std::move(points);
  surface.triangles = std::move(triangles);
  const std::size_t count = surface.points.size();
  surface.trianglesOf.resize(count);
  surface.quadrics.resize(count);
  surface.onBorder.assign(count, 0);
  surface.fixed.assign(count, 0);
  for (std::uint32_t i = 0; i < surface.triangles.size(); ++i) {
    for (const std::uint32_t corner : surface.triangles[i]) surface.trianglesOf[corner].push_back(i);
    addTriangleQuadrics(surface, surface.triangles[i]);
  }
  for (std::uint32_t point = 0; point < count; ++point) inspectEdges(surface, point);
  return surface;
}

bool mayCollapse(const CollapsibleSurface& surface, std::uint32_t a, std::uint32_t b, const Vector3d& place) {
  return !surface.fixed[a] && !surface.fixed[b] && linkAllows(surface, a, b) &&
         shapeAllows(surface, a, b, place) && shapeAllows(surface, b, a, place);
}

void collapse(CollapsibleSurface& surface, std::uint32_t a, std::uint32_t b, const Vector3d& place) {
  for (const std::uint32_t i : sharedTriangles(surface, a, b)) {
    for (const std::uint32_t corner : surface.triangles[i]) {
      std::vector<std::uint32_t>& list = surface.trianglesOf[corner];
      list.erase(std::lower_bound(list.begin(), list.end(), i));
    }
  }
  for (const std::uint32_t i : surface.trianglesOf[b]) {
    for (std::uint32_t& corner : surface.triangles[i]) corner = corner == b ? a : corner;
  }
  std::vector<std::uint32_t> joined;
  std::merge(surface.trianglesOf[a].begin(), surface.trianglesOf[a].end(), surface.trianglesOf[b].begin(),
             surface.trianglesOf[b].end(), std::back_inserter(joined));
  surface.trianglesOf[a] = std::move(joined);
  surface.trianglesOf[b].clear();
  surface.points[a] = place;
  surface.quadrics[a] += surface.quadrics[b];
  surface.onBorder[a] = surface.onBorder[a] || surface.onBorder[b];
}

}  // namespace limber
