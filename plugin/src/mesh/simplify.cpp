// SPDX-License-Identifier: Zlib
// Simplifies a mesh to a given number of points. Collapses edges in the order of their quadric error, and
// keeps the topology of the surface and the shape of its triangles.

#include <limber/mesh.h>

#include "mesh/linear_algebra.h"
#include "mesh/surface.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <queue>
#include <tuple>

namespace limber {
namespace {

using Eigen::Vector3d;
using Indices = std::vector<std::uint32_t>;

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

  /// Returns the position of the minimum. At least one point must be in the quadric, because with planes
  /// alone the minimum may be a line or more.
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

/// A surface whose edges can be collapsed. Removed points have no triangles; removed triangles are in no
/// list.
struct CollapsibleSurface {
  std::vector<Eigen::Vector3d> points;
  std::vector<Triangle> triangles;
  std::vector<Indices> trianglesOf;  ///< #points, ascending
  std::vector<Quadric> quadrics;     ///< #points
  std::vector<char> onBorder;        ///< #points, on an edge of one triangle
  std::vector<char> fixed;           ///< #points, where the surface is not manifold: never moved
};

/// Weight of the points of a patch in the quadric of its new point, relative to its planes. It is large
/// enough to spread points evenly where the surface is flat, and too small to pull them below it where it is
/// curved.
constexpr double kPointWeight = 1e-3;
/// Planes through the borders, normal to the surface, keep them in place. Their weight is this times the
/// border's squared length.
constexpr double kBorderWeight = 10.0;
/// Cosine of the largest rotation of a triangle's normal in one collapse.
constexpr double kMinRotationCosine = 0.3;
/// Smallest quality of a new triangle,  4 sqrt(3) area / sum of squared sides  (1: equilateral), unless one
/// of the old ones was worse.
constexpr double kMinQuality = 0.15;

/// A quality of slivers that is lower by this factor is no worse.
constexpr double kMuchWorse = 0.7;

bool contains(const Triangle& t, std::uint32_t point) {
  return t[0] == point || t[1] == point || t[2] == point;
}

double quality(const TriangleCorners& t) {
  const double sides =
      (t[1] - t[0]).squaredNorm() + (t[2] - t[1]).squaredNorm() + (t[0] - t[2]).squaredNorm();
  return sides > 0.0 ? 4.0 * std::sqrt(3.0) * areaVector(t).norm() / sides : 0.0;
}

/// Returns what two ascending lists have in common.
Indices common(const Indices& a, const Indices& b) {
  Indices result;
  std::set_intersection(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(result));
  return result;
}

Indices sharedTriangles(const CollapsibleSurface& surface, std::uint32_t a, std::uint32_t b) {
  return common(surface.trianglesOf[a], surface.trianglesOf[b]);
}

/// Returns the neighbours of a point, ascending, without `point`.
Indices neighboursOf(const CollapsibleSurface& surface, std::uint32_t point) {
  Indices neighbours;
  for (const std::uint32_t i : surface.trianglesOf[point]) {
    for (const std::uint32_t corner : surface.triangles[i]) {
      if (corner != point) neighbours.push_back(corner);
    }
  }
  sortUnique(neighbours);
  return neighbours;
}

void addTriangleQuadrics(CollapsibleSurface& surface, const Triangle& t) {
  const Vector3d vector = areaVector(surface.points, t);
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
  const Vector3d across = side.cross(areaVector(surface.points, t)).normalized();
  const Quadric plane = planeQuadric(across, surface.points[a], kBorderWeight * side.squaredNorm());
  surface.quadrics[a] += plane;
  surface.quadrics[b] += plane;
}

/// Marks borders and points whose triangles are not one fan, and adds the quadrics of the borders.
void inspectEdges(CollapsibleSurface& surface, std::uint32_t a) {
  std::size_t borders = 0;
  for (const std::uint32_t b : neighboursOf(surface, a)) {
    const Indices shared = sharedTriangles(surface, a, b);
    if (shared.size() > 2) surface.fixed[a] = 1;
    if (shared.size() != 1) continue;
    ++borders;
    surface.onBorder[a] = 1;
    if (a < b) addBorderQuadric(surface, a, b, surface.triangles[shared[0]]);
  }
  if (borders > 2) surface.fixed[a] = 1;
}

/// Checks the link condition: the common neighbours must be the third corners of the triangles at the edge,
/// and these must keep enough triangles: three within the surface, one on its border.
bool linkAllows(const CollapsibleSurface& surface, std::uint32_t a, std::uint32_t b) {
  const Indices shared = sharedTriangles(surface, a, b);
  if (shared.empty() || shared.size() > 2) return false;
  if (surface.onBorder[a] && surface.onBorder[b] && shared.size() == 2) return false;
  const Indices apexes = common(neighboursOf(surface, a), neighboursOf(surface, b));
  if (apexes.size() != shared.size()) return false;
  return std::all_of(apexes.begin(), apexes.end(), [&](std::uint32_t apex) {
    return surface.trianglesOf[apex].size() > (surface.onBorder[apex] ? 1u : 3u);
  });
}

/// Whether joining a and b would make two triangles with the same corners.
bool closesLobe(const CollapsibleSurface& surface, std::uint32_t a, std::uint32_t b) {
  for (const std::uint32_t i : surface.trianglesOf[b]) {
    const Triangle& t = surface.triangles[i];
    if (contains(t, a)) continue;
    const auto isSame = [&](std::uint32_t j) {
      return std::all_of(t.begin(), t.end(), [&](std::uint32_t corner) {
        return corner == b || contains(surface.triangles[j], corner);
      });
    };
    if (std::any_of(surface.trianglesOf[a].begin(), surface.trianglesOf[a].end(), isSame)) return true;
  }
  return false;
}

/// Returns the quality that triangles around a and b must keep. Among slivers they may become a little worse:
/// a fan or a band of them could else never be simplified.
double leastQuality(const CollapsibleSurface& surface, std::uint32_t a, std::uint32_t b) {
  double worst = kMinQuality / kMuchWorse;
  for (const std::uint32_t end : {a, b})
    for (const std::uint32_t t : surface.trianglesOf[end])
      worst = std::min(worst, quality(cornersOf(surface.points, surface.triangles[t])));
  return kMuchWorse * worst;
}

/// Checks the remaining triangles of `moved`, whose quality must be at least `least`.
bool shapeAllows(const CollapsibleSurface& surface, std::uint32_t moved, std::uint32_t other,
                 const Vector3d& position, double least) {
  for (const std::uint32_t i : surface.trianglesOf[moved]) {
    const Triangle& t = surface.triangles[i];
    if (contains(t, other)) continue;
    const TriangleCorners before = cornersOf(surface.points, t);
    TriangleCorners after = before;
    for (std::size_t c = 0; c < 3; ++c)
      if (t[c] == moved) after[c] = position;
    const Vector3d oldArea = areaVector(before), newArea = areaVector(after);
    if (oldArea.dot(newArea) <= kMinRotationCosine * oldArea.norm() * newArea.norm()) return false;
    if (quality(after) < least) return false;
  }
  return true;
}

CollapsibleSurface makeCollapsible(std::vector<Vector3d> points, std::vector<Triangle> triangles) {
  CollapsibleSurface surface;
  surface.points = std::move(points);
  surface.triangles = std::move(triangles);
  const std::size_t count = surface.points.size();
  surface.trianglesOf = elementsOfPoints(count, surface.triangles);
  surface.quadrics.resize(count);
  surface.onBorder.assign(count, 0);
  surface.fixed.assign(count, 0);
  for (const Triangle& t : surface.triangles) addTriangleQuadrics(surface, t);
  for (std::uint32_t point = 0; point < count; ++point) inspectEdges(surface, point);
  return surface;
}

/// Returns whether joining a and b at `position` keeps the topology of the surface (the link condition: Dey,
/// Edelsbrunner, Guha, Nekhayev 1999) and does not flip a triangle or make a sliver.
bool mayCollapse(const CollapsibleSurface& surface, std::uint32_t a, std::uint32_t b,
                 const Vector3d& position) {
  if (surface.fixed[a] || surface.fixed[b] || !linkAllows(surface, a, b) || closesLobe(surface, a, b))
    return false;
  const double least = leastQuality(surface, a, b);
  return shapeAllows(surface, a, b, position, least) && shapeAllows(surface, b, a, position, least);
}

/// Moves a to `position` and removes b.
void collapse(CollapsibleSurface& surface, std::uint32_t a, std::uint32_t b, const Vector3d& position) {
  for (const std::uint32_t i : sharedTriangles(surface, a, b)) {
    for (const std::uint32_t corner : surface.triangles[i]) {
      Indices& list = surface.trianglesOf[corner];
      list.erase(std::lower_bound(list.begin(), list.end(), i));
    }
  }
  for (const std::uint32_t i : surface.trianglesOf[b]) {
    for (std::uint32_t& corner : surface.triangles[i]) corner = corner == b ? a : corner;
  }
  Indices joined;
  std::merge(surface.trianglesOf[a].begin(), surface.trianglesOf[a].end(), surface.trianglesOf[b].begin(),
             surface.trianglesOf[b].end(), std::back_inserter(joined));
  surface.trianglesOf[a] = std::move(joined);
  surface.trianglesOf[b].clear();
  surface.points[a] = position;
  surface.quadrics[a] += surface.quadrics[b];
  surface.onBorder[a] = surface.onBorder[a] || surface.onBorder[b];
}

/// An edge to collapse, valid while neither end has changed.
struct Candidate {
  double cost;
  std::uint32_t a, b;                ///< a < b
  std::uint32_t changesA, changesB;  ///< of the ends when the cost was computed

  /// The smallest cost is on top of a heap; candidates of equal cost are in the order of their points.
  bool operator<(const Candidate& t) const { return std::tie(cost, a, b) > std::tie(t.cost, t.a, t.b); }
};

using Heap = std::priority_queue<Candidate>;

struct Simplifier {
  CollapsibleSurface surface;
  Indices changes;  ///< #points, how many
  Heap heap;
};

Quadric summedQuadric(const CollapsibleSurface& surface, std::uint32_t a, std::uint32_t b) {
  Quadric sum = surface.quadrics[a];
  return sum += surface.quadrics[b];
}

void pushCandidate(Simplifier& work, std::uint32_t a, std::uint32_t b) {
  if (a > b) std::swap(a, b);
  const Quadric sum = summedQuadric(work.surface, a, b);
  work.heap.push({sum.at(sum.minimum()), a, b, work.changes[a], work.changes[b]});
}

void pushAllCandidates(Simplifier& work) {
  for (std::uint32_t a = 0; a < work.surface.points.size(); ++a) {
    for (const std::uint32_t b : neighboursOf(work.surface, a)) {
      if (a < b) pushCandidate(work, a, b);
    }
  }
}

/// Collapses edges of the heap where possible, until `excess` points are removed. Returns the number of
/// removed points.
std::size_t collapseCheapest(Simplifier& work, std::size_t excess) {
  std::size_t removed = 0;
  while (removed < excess && !work.heap.empty()) {
    const Candidate edge = work.heap.top();
    work.heap.pop();
    if (work.changes[edge.a] != edge.changesA || work.changes[edge.b] != edge.changesB) continue;
    const Vector3d position = summedQuadric(work.surface, edge.a, edge.b).minimum();
    if (!mayCollapse(work.surface, edge.a, edge.b, position)) continue;
    collapse(work.surface, edge.a, edge.b, position);
    ++work.changes[edge.a];
    ++work.changes[edge.b];
    ++removed;
    for (const std::uint32_t neighbour : neighboursOf(work.surface, edge.a))
      pushCandidate(work, edge.a, neighbour);
  }
  return removed;
}

/// Repeats rounds until no edge can be collapsed: rejected edges may be allowed after changes around them.
void collapseTo(Simplifier& work, std::size_t points) {
  std::size_t excess = work.surface.points.size() - points;
  for (std::size_t removed = 1; removed > 0 && excess > 0; excess -= removed) {
    work.heap = Heap();
    pushAllCandidates(work);
    removed = collapseCheapest(work, excess);
  }
}

TriangleMesh compacted(const CollapsibleSurface& surface) {
  Renumbering numbers(surface.points.size());
  for (std::uint32_t point = 0; point < surface.points.size(); ++point)
    if (!surface.trianglesOf[point].empty()) numbers(point);
  TriangleMesh mesh = meshOf(chosen(surface.points, numbers.kept()), {});
  for (std::uint32_t i = 0; i < surface.triangles.size(); ++i) {
    const Triangle& t = surface.triangles[i];
    const Indices& list = surface.trianglesOf[t[0]];
    if (std::binary_search(list.begin(), list.end(), i)) mesh.triangles.push_back(numbers(t));
  }
  return mesh;
}

}  // namespace

Result<TriangleMesh> simplify(const TriangleMesh& mesh, std::uint32_t points) {
  if (points < 4) {
    return Error{"simplify() cannot make a mesh of " + std::to_string(points) +
                 " points, it needs 4 or more"};
  }
  Result<WeldedMesh> welded = weld(mesh);
  if (!welded) return Error{welded.error()};
  const Eigen::AlignedBox3d box = boxOf(welded->points);
  const Vector3d centre = box.center();
  const double size = box.sizes().maxCoeff();
  // quadrics of coordinates far from the origin would suffer from cancellation
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
