// SPDX-License-Identifier: Zlib
// Computes the edges, the components and the geometry of surfaces, and flips closed surfaces to face outward.

#include "mesh/surface.h"

#include "mesh/edges.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace limber {
namespace {

using Eigen::Vector3d;

/// One side of a triangle: its edge, and whether the triangle runs through it from the smaller to the larger
/// index.
struct HalfEdge {
  Edge edge;
  bool upward;
};

HalfEdge halfEdge(std::uint32_t from, std::uint32_t to) {
  return from < to ? HalfEdge{{from, to}, true} : HalfEdge{{to, from}, false};
}

std::vector<HalfEdge> sortedHalfEdges(const std::vector<Triangle>& triangles) {
  std::vector<HalfEdge> sides;
  sides.reserve(3 * triangles.size());
  for (const Triangle& t : triangles) {
    for (std::size_t corner = 0; corner < 3; ++corner)
      sides.push_back(halfEdge(t[corner], t[(corner + 1) % 3]));
  }
  std::sort(sides.begin(), sides.end(), [](const HalfEdge& s, const HalfEdge& t) { return s.edge < t.edge; });
  return sides;
}

}  // namespace

std::vector<Edge> uniqueEdges(const std::vector<Triangle>& triangles) {
  std::vector<Edge> edges;
  for (const HalfEdge& side : sortedHalfEdges(triangles)) {
    if (edges.empty() || edges.back() != side.edge) edges.push_back(side.edge);
  }
  return edges;
}

EdgeDefects findEdgeDefects(const std::vector<Triangle>& triangles) {
  const std::vector<HalfEdge> sides = sortedHalfEdges(triangles);
  EdgeDefects defects;
  for (std::size_t first = 0, last = 0; first < sides.size(); first = last) {
    while (last < sides.size() && sides[last].edge == sides[first].edge) ++last;
    const std::size_t uses = last - first;
    if (uses == 1) ++defects.open;
    if (uses > 2) ++defects.nonManifold;
    if (uses == 2 && sides[first].upward == sides[first + 1].upward) ++defects.inconsistent;
  }
  return defects;
}

void setEdgeDefects(MeshReport& report, const std::vector<Triangle>& triangles) {
  const EdgeDefects defects = findEdgeDefects(triangles);
  report.openEdges = defects.open;
  report.nonManifoldEdges = defects.nonManifold;
  report.inconsistentEdges = defects.inconsistent;
}

SurfaceComponents findComponents(std::size_t points, const std::vector<Triangle>& triangles) {
  constexpr std::uint32_t kUnnumbered = 0xffffffffu;
  DisjointSets sets(points);
  for (const Triangle& t : triangles) {
    sets.join(t[0], t[1]);
    sets.join(t[0], t[2]);
  }
  SurfaceComponents components;
  std::vector<std::uint32_t> number(points, kUnnumbered);
  for (const Triangle& t : triangles) {
    std::uint32_t& n = number[sets.root(t[0])];
    if (n == kUnnumbered) n = static_cast<std::uint32_t>(components.count++);
    components.ofTriangle.push_back(n);
  }
  return components;
}

std::optional<LineHit> intersectLine(const TriangleCorners& t, const Vector3d& origin,
                                     const Vector3d& direction, double margin) {
  const Vector3d e1 = t[1] - t[0], e2 = t[2] - t[0];
  const Vector3d h = direction.cross(e2);
  const double determinant = e1.dot(h);
  if (determinant == 0.0) return std::nullopt;
  const Vector3d s = origin - t[0], q = s.cross(e1);
  const double v = s.dot(h) / determinant, w = direction.dot(q) / determinant;
  // the negation also rejects NaN
  if (!(v >= -margin && w >= -margin && v + w <= 1.0 + margin)) return std::nullopt;
  return LineHit{e2.dot(q) / determinant, Vector3d(1.0 - v - w, v, w)};
}

double solidAngle(const TriangleCorners& t, const Vector3d& p) {
  const Vector3d a = t[0] - p, b = t[1] - p, c = t[2] - p;
  const double la = a.norm(), lb = b.norm(), lc = c.norm();
  const double numerator = a.dot(b.cross(c));
  const double denominator = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
  return numerator == 0.0 ? 0.0 : 2.0 * std::atan2(numerator, denominator);
}

double extent(const Eigen::Ref<const Eigen::Matrix3Xd>& points) {
  if (points.cols() == 0) return 0.0;
  return (points.rowwise().maxCoeff() - points.rowwise().minCoeff()).maxCoeff();
}

double extent(const std::vector<Vector3d>& points) {
  if (points.empty()) return 0.0;
  return extent(
      Eigen::Map<const Eigen::Matrix3Xd>(points.front().data(), 3, static_cast<Eigen::Index>(points.size())));
}

double signedVolume(const std::vector<Vector3d>& points, const std::vector<Triangle>& triangles) {
  if (triangles.empty()) return 0.0;
  const Vector3d& origin = points[triangles[0][0]];
  double six = 0.0;
  for (const Triangle& t : triangles)
    six += (points[t[0]] - origin).dot((points[t[1]] - origin).cross(points[t[2]] - origin));
  return six / 6.0;
}

std::vector<Vector3d> vertexNormals(const std::vector<Vector3d>& points,
                                    const std::vector<Triangle>& triangles) {
  std::vector<Vector3d> normals(points.size(), Vector3d::Zero());
  for (const Triangle& t : triangles) {
    const Vector3d twiceArea = (points[t[1]] - points[t[0]]).cross(points[t[2]] - points[t[0]]);
    for (const std::uint32_t corner : t) normals[corner] += twiceArea;
  }
  for (Vector3d& normal : normals) normal.normalize();
  return normals;
}

namespace {

struct Component {
  std::vector<Triangle> triangles;
  Eigen::AlignedBox3d box;
  double volume = 0.0;  ///< m^3, signed; 0 unless closed
};

std::vector<Component> split(const std::vector<Vector3d>& points, const std::vector<Triangle>& triangles,
                             const SurfaceComponents& components) {
  std::vector<Component> parts(components.count);
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    Component& part = parts[components.ofTriangle[t]];
    part.triangles.push_back(triangles[t]);
    for (const std::uint32_t corner : triangles[t]) part.box.extend(points[corner]);
  }
  for (Component& part : parts) {
    if (findEdgeDefects(part.triangles).none()) part.volume = signedVolume(points, part.triangles);
  }
  return parts;
}

/// Returns whether a corner of `inner` is inside `outer`. Components that pass through each other are not
/// within each other.
bool isWithin(const std::vector<Vector3d>& points, const Component& inner, const Component& outer) {
  if (!outer.box.contains(inner.box)) return false;
  const Vector3d& corner = points[inner.triangles.front().front()];
  double angle = 0.0;
  for (const Triangle& t : outer.triangles)
    angle += solidAngle({points[t[0]], points[t[1]], points[t[2]]}, corner);
  return std::abs(angle) > 2.0 * kPi;
}

const Component& outermostAround(const std::vector<Vector3d>& points, const Component& part,
                                 const std::vector<Component>& parts) {
  const Component* outermost = &part;
  for (const Component& other : parts)
    if (std::abs(other.volume) > std::abs(outermost->volume) && isWithin(points, part, other))
      outermost = &other;
  return *outermost;
}

}  // namespace

std::vector<bool> facingInward(const std::vector<Vector3d>& points, const std::vector<Triangle>& triangles) {
  const SurfaceComponents components = findComponents(points.size(), triangles);
  const std::vector<Component> parts = split(points, triangles, components);
  if (std::none_of(parts.begin(), parts.end(), [](const Component& c) { return c.volume < 0.0; }))
    return std::vector<bool>(triangles.size(), false);
  std::vector<bool> flipped;
  for (const Component& part : parts)
    flipped.push_back(part.volume != 0.0 && outermostAround(points, part, parts).volume < 0.0);
  std::vector<bool> marked;
  for (const std::uint32_t component : components.ofTriangle) marked.push_back(flipped[component]);
  return marked;
}

void flip(std::vector<Triangle>& triangles, const std::vector<bool>& marked) {
  for (std::size_t t = 0; t < triangles.size(); ++t)
    if (marked[t]) std::swap(triangles[t][1], triangles[t][2]);
}

std::vector<Triangle> facingOutward(const std::vector<Vector3d>& points, std::vector<Triangle> triangles) {
  flip(triangles, facingInward(points, triangles));
  return triangles;
}

}  // namespace limber
