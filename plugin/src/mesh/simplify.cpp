// SPDX-License-Identifier: Zlib
// Simplifies a mesh to a given number of points. It collapses edges in the order of their quadric error, and
// keeps the topology of the surface and the shape of its triangles.

#include <limber/simplify_mesh.h>

#include "mesh/surface.h"
#include "solver/linear_algebra.h"

#include <limber/mesh_weld.h>
#include <limber/triangle_mesh.h>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <queue>
#include <tuple>
#include <utility>
#include <vector>

namespace limber {
namespace {

using Eigen::Vector3d;

/// Weighted sum of squared distances from planes and points,  x^T a x - 2 b^T x + c  (M. Garland, P.
/// Heckbert, "Surface simplification using quadric error metrics", 1997).
struct Quadric {
  Eigen::Matrix3d a = Eigen::Matrix3d::Zero();
  Eigen::Vector3d b = Eigen::Vector3d::Zero();
  double c = 0.0;

  Quadric& operator+=(const Quadric& other) {
    a += other.a;
    b += other.b;
    c += other.c;
    return *this;
  }
  double at(const Eigen::Vector3d& x) const { return x.dot(a * x) - 2.0 * b.dot(x) + c; }

  /// Where it is least; some point must be in it, for planes alone may leave a line or more.
  Eigen::Vector3d minimum() const {
    Eigen::Vector3d x = b;
    solveSmall(a, x);
    return x;
  }
};

Quadric planeQuadric(const Vector3d& unitNormal, const Vector3d& through, double weight) {
  const double offset = unitNormal.dot(through);
  return {weight * unitNormal * unitNormal.transpose(), weight * offset * unitNormal,
          weight * offset * offset};
}

Quadric pointQuadric(const Eigen::Vector3d& point, double weight) {
  return {weight * Eigen::Matrix3d::Identity(), weight * point, weight * point.squaredNorm()};
}

/// A surface whose edges can be collapsed. Dead points have no triangles; dead triangles are in no list.
struct CollapsibleSurface {
  std::vector<Eigen::Vector3d> points;
  std::vector<Triangle> triangles;
  std::vector<std::vector<std::uint32_t>> trianglesOf;  ///< #points, ascending
  std::vector<Quadric> quadrics;                        ///< #points
  std::vector<char> onBorder;                           ///< #points, on an edge of one triangle
  std::vector<char> fixed;  ///< #points, where the surface is not manifold: never moved
};

/// Points of a patch pull at its new point with this part of the weight of its planes: enough to spread
/// points evenly where the surface is flat, too little to pull them below it where it is curved.
constexpr double kPointWeight = 1e-3;
/// Borders are held by planes through them across the surface, of this weight times their squared length.
constexpr double kBorderWeight = 10.0;
/// Cosine of the largest turn of a triangle in one collapse.
constexpr double kLargestFaceTurn = 0.3;
/// The least quality of a new triangle,  4 sqrt(3) area / sum of squared sides  (1: equilateral), unless the
/// old one was worse.
constexpr double kMinQuality = 0.15;

bool contains(const Triangle& t, std::uint32_t point) {
  return t[0] == point || t[1] == point || t[2] == point;
}

Vector3d areaVectorOf(const CollapsibleSurface& surface, const Triangle& t) {
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

/// Ascending, without `point`.
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

void addTriangleQuadrics(CollapsibleSurface& surface, const Triangle& t) {
  const Vector3d vector = areaVectorOf(surface, t);
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
  const Vector3d across = side.cross(areaVectorOf(surface, t)).normalized();
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
    const double least = std::min(kMinQuality, quality(before[0], before[1], before[2]));
    if (quality(after[0], after[1], after[2]) < least) return false;
  }
  return true;
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

/// Whether joining a and b at `place` leaves a surface of the same topology (the link condition: Dey,
/// Edelsbrunner, Guha, Nekhayev 1999), and no triangle turned over or made a sliver.
bool mayCollapse(const CollapsibleSurface& surface, std::uint32_t a, std::uint32_t b, const Vector3d& place) {
  return !surface.fixed[a] && !surface.fixed[b] && linkAllows(surface, a, b) &&
         shapeAllows(surface, a, b, place) && shapeAllows(surface, b, a, place);
}

/// Moves a to `place` and lets b die.
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

/// An edge to collapse, valid as long as neither end has changed since.
struct Candidate {
  double cost;
  std::uint32_t a, b;                ///< a < b
  std::uint32_t changesA, changesB;  ///< of the ends when the cost was found
};

/// For a heap with the cheapest on top; equally cheap ones in the order of their points.
struct IsDearer {
  bool operator()(const Candidate& s, const Candidate& t) const {
    return std::tie(s.cost, s.a, s.b) > std::tie(t.cost, t.a, t.b);
  }
};

using Heap = std::priority_queue<Candidate, std::vector<Candidate>, IsDearer>;

struct Simplifier {
  CollapsibleSurface surface;
  std::vector<std::uint32_t> changes;  ///< #points
  Heap heap;
};

Quadric joint(const CollapsibleSurface& surface, std::uint32_t a, std::uint32_t b) {
  Quadric sum = surface.quadrics[a];
  return sum += surface.quadrics[b];
}

void offer(Simplifier& work, std::uint32_t a, std::uint32_t b) {
  if (a > b) std::swap(a, b);
  const Quadric sum = joint(work.surface, a, b);
  work.heap.push({sum.at(sum.minimum()), a, b, work.changes[a], work.changes[b]});
}

void offerAll(Simplifier& work) {
  for (std::uint32_t a = 0; a < work.surface.points.size(); ++a) {
    for (const std::uint32_t b : neighboursOf(work.surface, a)) {
      if (a < b) offer(work, a, b);
    }
  }
}

/// Collapses what it can of the edges on offer until `excess` points are gone; how many are.
std::size_t collapseCheapest(Simplifier& work, std::size_t excess) {
  std::size_t gone = 0;
  while (gone < excess && !work.heap.empty()) {
    const Candidate edge = work.heap.top();
    work.heap.pop();
    if (work.changes[edge.a] != edge.changesA || work.changes[edge.b] != edge.changesB) continue;
    const Vector3d place = joint(work.surface, edge.a, edge.b).minimum();
    if (!mayCollapse(work.surface, edge.a, edge.b, place)) continue;
    collapse(work.surface, edge.a, edge.b, place);
    ++work.changes[edge.a];
    ++work.changes[edge.b];
    ++gone;
    for (const std::uint32_t neighbour : neighboursOf(work.surface, edge.a)) offer(work, edge.a, neighbour);
  }
  return gone;
}

/// Edges that were refused may be allowed once their surroundings have changed: rounds until none is.
void collapseTo(Simplifier& work, std::size_t points) {
  std::size_t excess = work.surface.points.size() - points;
  for (std::size_t gone = 1; gone > 0 && excess > 0; excess -= gone) {
    work.heap = Heap();
    offerAll(work);
    gone = collapseCheapest(work, excess);
  }
}

TriangleMesh compacted(const CollapsibleSurface& surface) {
  TriangleMesh mesh;
  std::vector<std::uint32_t> number(surface.points.size(), kNoPoint);
  for (std::uint32_t point = 0; point < surface.points.size(); ++point) {
    if (surface.trianglesOf[point].empty()) continue;
    number[point] = static_cast<std::uint32_t>(mesh.positions.size());
    mesh.positions.push_back(surface.points[point]);
  }
  for (std::uint32_t i = 0; i < surface.triangles.size(); ++i) {
    const Triangle& t = surface.triangles[i];
    const std::vector<std::uint32_t>& list = surface.trianglesOf[t[0]];
    if (!std::binary_search(list.begin(), list.end(), i)) continue;
    mesh.triangles.push_back({number[t[0]], number[t[1]], number[t[2]]});
  }
  return mesh;
}

}  // namespace

Result<TriangleMesh> simplify(const TriangleMesh& mesh, std::uint32_t points) {
  if (points < 4) {
    return Error{"simplify was asked for " + std::to_string(points) + " points, it needs 4 or more"};
  }
  Result<WeldedMesh> welded = weld(mesh);
  if (!welded) return Error{welded.error()};
  Eigen::AlignedBox3d box;
  for (const Vector3d& p : welded->points) box.extend(p);
  const Vector3d centre = box.center();
  const double size = box.sizes().maxCoeff();
  // quadrics of coordinates far from the origin would cancel
  std::vector<Vector3d> unit;
  for (const Vector3d& p : welded->points) unit.emplace_back((p - centre) / size);

  Simplifier work;
  work.surface = makeCollapsible(std::move(unit), std::move(welded->triangles));
  work.changes.assign(work.surface.points.size(), 0);
  if (work.surface.points.size() > points) collapseTo(work, points);
  TriangleMesh coarse = compacted(work.surface);
  for (Vector3d& p : coarse.positions) p = centre + size * p;
  return coarse;
}

}  // namespace limber
