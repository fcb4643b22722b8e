// SPDX-License-Identifier: Zlib
#include <limber/simplify_mesh.h>

#include "cook/edge_collapse.h"

#include <limber/mesh_weld.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <queue>
#include <tuple>
#include <utility>

namespace limber {
namespace {

using Eigen::Vector3d;

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
