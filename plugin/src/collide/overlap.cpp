// SPDX-License-Identifier: Zlib

// This file separates closed surfaces that have been placed into each other. Each vertex inside gets a
// contact, all along one direction: the nearest ways out of different vertices lead to different sides, and
// would entangle the surfaces.

#include "collide/feature_contacts.h"

#include <cmath>

namespace limber {
namespace {

using Eigen::Vector3d;

Eigen::AlignedBox3d boxOf(const Points& x) { return {x.rowwise().minCoeff(), x.rowwise().maxCoeff()}; }

/// Writes to `inside` the vertices of a surface that are deeper than `depth` (m) inside the other, with the
/// triangles of the nearest way out.
void findInside(const MovingSurface& own, const MovingSurface& other, bool ofB, double depth,
                std::vector<PenetratingVertex>& inside) {
  const Eigen::AlignedBox3d box = boxOf(*other.position);
  const double farthest = box.diagonal().norm();
  for (const std::uint32_t v : own.topology->vertices) {
    const Vector3d x = own.position->col(v);
    if (!box.contains(x)) continue;
    const NearestOnSurface nearest = nearestOnSurface(other, x, farthest);
    if (nearest.behind && nearest.distance > depth)
      inside.push_back({ofB, v, nearest.triangle, nearest.distance, false, nearest.barycentric});
  }
}

/// Whether a surface is a copy of the other at the same place. No vertex is deeper inside than on the
/// surface.
bool coincide(const SurfacePair& pair) {
  const Points &a = *pair.a.position, &b = *pair.b.position;
  return a.cols() == b.cols() && pair.a.topology->vertices == pair.b.topology->vertices &&
         (a - b).colwise().norm().maxCoeff() <= pair.radiusSum();
}

void addAll(const MovingSurface& own, bool ofB, std::vector<PenetratingVertex>& inside) {
  for (const std::uint32_t v : own.topology->vertices)
    inside.push_back({ofB, v, *own.topology->trianglesAround.begin(v)});
}

/// Returns how far (m) surface a must move along the unit `direction` to be beyond b. It is exact for convex
/// surfaces, and else too much.
double wayBeyond(const MovingSurface& a, const MovingSurface& b, const Vector3d& direction) {
  return (direction.transpose() * *b.position).maxCoeff() - (direction.transpose() * *a.position).minCoeff();
}

/// Returns the sum of a third of the area vectors (m^2) of the triangles around a vertex.
Vector3d areaAt(const MovingSurface& surface, std::uint32_t vertex) {
  const SurfaceTopology& t = *surface.topology;
  Vector3d sum = Vector3d::Zero();
  for (const std::uint32_t* i = t.trianglesAround.begin(vertex); i != t.trianglesAround.end(vertex); ++i) {
    const auto c = featureOf<3>(surface, t.triangles[*i]).start;
    sum += (c.col(1) - c.col(0)).cross(c.col(2) - c.col(0)) / 6.0;
  }
  return sum;
}

/// Returns the unit direction in which surface a gets out of b by the shortest way: along which their common
/// volume falls fastest (the sum of the area vectors of what is inside), away from b's centre, or along the
/// normal of one of the nearest triangles.
Vector3d wayOut(const SurfacePair& pair, const std::vector<PenetratingVertex>& inside) {
  Vector3d area = Vector3d::Zero();
  for (const PenetratingVertex& v : inside)
    area += v.ofB ? areaAt(pair.b, v.vertex) : Vector3d(-areaAt(pair.a, v.vertex));
  Vector3d best = Vector3d::UnitY();
  double shortest = wayBeyond(pair.a, pair.b, best);
  const auto consider = [&](const Vector3d& direction) {
    if (!(direction.norm() > 0.0)) return;
    const Vector3d unit = direction.normalized();
    if (const double way = wayBeyond(pair.a, pair.b, unit); way < shortest) shortest = way, best = unit;
  };
  consider(area);
  consider(pair.a.position->rowwise().mean() - pair.b.position->rowwise().mean());
  std::uint32_t last = kNoFeature;
  for (const PenetratingVertex& v : inside) {
    if (v.triangle == last) continue;
    last = v.triangle;
    consider(v.ofB ? Vector3d(-normalAt(pair.a, 0.0, last)) : normalAt(pair.b, 0.0, last));
  }
  return best;
}

/// Where a ray leaves a surface.
struct Exit {
  std::uint32_t triangle = kNoFeature;  ///< kNoFeature: nowhere
  double distance = HUGE_VAL;           ///< m
  Vector3d barycentric = Vector3d::Zero();
};

/// Makes `exit` the intersection of a ray from inside with a triangle, if it leaves there and no later.
void intersect(const MovingSurface& surface, std::uint32_t triangle, const Vector3d& origin,
               const Vector3d& direction, Exit& exit) {
  constexpr double kOnEdge = -1e-9;
  const auto c = featureOf<3>(surface, surface.topology->triangles[triangle]).start;
  const Vector3d u = c.col(1) - c.col(0), v = c.col(2) - c.col(0), normal = u.cross(v);
  const double along = normal.dot(direction);
  if (!(along > 0.0)) return;
  const Vector3d to = c.col(0) - origin;
  const double distance = normal.dot(to) / along;
  if (distance < 0.0 || distance >= exit.distance) return;
  const Vector3d p = distance * direction - to;
  const double squared = normal.squaredNorm();
  const double second = normal.dot(p.cross(v)) / squared, third = normal.dot(u.cross(p)) / squared;
  const Vector3d weights(1.0 - second - third, second, third);
  if (!(weights.minCoeff() >= kOnEdge)) return;
  exit = {triangle, distance, weights.cwiseMax(0.0) / weights.cwiseMax(0.0).sum()};
}

bool meetsBox(const SweptBox& box, const Vector3d& origin, const Vector3d& direction, double within) {
  double enter = 0.0, leave = within;
  for (Eigen::Index i = 0; i < 3; ++i) {
    if (direction[i] == 0.0) {
      if (origin[i] < box.low[i] || origin[i] > box.high[i]) return false;
      continue;
    }
    const double a = (box.low[i] - origin[i]) / direction[i], b = (box.high[i] - origin[i]) / direction[i];
    enter = std::max(enter, std::min(a, b));
    leave = std::min(leave, std::max(a, b));
  }
  return enter <= leave;
}

Exit exitAlong(const MovingSurface& surface, const Vector3d& origin, const Vector3d& direction,
               LeafPairs& waiting) {
  const SurfaceTopology& t = *surface.topology;
  Exit exit;
  waiting.assign(1, {0, 0});
  while (!waiting.empty()) {
    const std::uint32_t i = waiting.back().first;
    waiting.pop_back();
    if (!meetsBox(surface.boxes->nodes[i], origin, direction, exit.distance)) continue;
    const SurfaceNode& node = t.nodes[i];
    if (node.element == kNoFeature) {
      waiting.push_back({node.child, 0});
      waiting.push_back({node.child + 1, 0});
    } else if (const std::uint32_t triangle = t.elements[node.element].triangle; triangle != kNoFeature) {
      intersect(surface, triangle, origin, direction, exit);
    }
  }
  return exit;
}

}  // namespace

bool findOverlapContacts(const MovingSurface& a, const MovingSurface& b, ContactSearch& search,
                         std::vector<SurfaceContact>& found) {
  if (!isSolid(*a.topology) || !isSolid(*b.topology)) return false;
  const SurfacePair pair{a, b, 0.0, false, 0.0};
  std::vector<PenetratingVertex>& inside = search.penetrating;
  inside.clear();
  findInside(a, b, false, pair.radiusSum(), inside);
  const std::size_t ofA = inside.size();
  findInside(b, a, true, pair.radiusSum(), inside);
  const std::size_t ofB = inside.size() - ofA;
  if (inside.empty() && coincide(pair)) {
    addAll(a, false, inside);
    addAll(b, true, inside);
  } else if (inside.empty() || ofA == a.topology->vertices.size() || ofB == b.topology->vertices.size()) {
    return false;
  }
  const Vector3d out = wayOut(pair, inside);
  search.candidates.clear();
  for (PenetratingVertex& v : inside) {
    const Vector3d direction = v.ofB ? Vector3d(-out) : out;
    const Exit exit =
        exitAlong(v.ofB ? a : b, (v.ofB ? b : a).position->col(v.vertex), direction, search.waiting);
    if (exit.triangle == kNoFeature) continue;
    v.triangle = exit.triangle;
    v.barycentric = exit.barycentric;
    addVertexOnTriangle(pair, v, direction, 0.0, search);
  }
  found.clear();
  for (FeatureCandidate& candidate : search.candidates) {
    candidate.contact.separates = true;
    found.push_back(candidate.contact);
  }
  std::sort(found.begin(), found.end(),
            [](const SurfaceContact& x, const SurfaceContact& y) { return x.key < y.key; });
  return !found.empty();
}

}  // namespace limber
