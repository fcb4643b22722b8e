// SPDX-License-Identifier: Zlib
// Computes the edges, the components and the geometry of surfaces, flips closed surfaces to face outward, and
// finds nearest points.

#include "mesh/surface.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <queue>
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
  forEachEdge(triangles, [&](const Edge& edge, std::size_t) { edges.push_back(edge); });
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

std::vector<std::vector<Triangle>> trianglesOfPieces(const TriangleMesh& mesh) {
  const SurfaceComponents pieces = findComponents(mesh.positions.size(), mesh.triangles);
  std::vector<std::vector<Triangle>> triangles(pieces.count);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    triangles[pieces.ofTriangle[t]].push_back(mesh.triangles[t]);
  return triangles;
}

TriangleMesh partOf(const TriangleMesh& mesh, std::vector<Triangle> triangles) {
  TriangleMesh part;
  part.triangles = std::move(triangles);
  std::vector<std::uint32_t> newIndex(mesh.positions.size(), kNoPoint);
  for (Triangle& triangle : part.triangles) {
    for (std::uint32_t& corner : triangle) {
      if (newIndex[corner] == kNoPoint) {
        newIndex[corner] = static_cast<std::uint32_t>(part.positions.size());
        part.positions.push_back(mesh.positions[corner]);
        if (!mesh.normals.empty()) part.normals.push_back(mesh.normals[corner]);
        if (!mesh.uvs.empty()) part.uvs.push_back(mesh.uvs[corner]);
      }
      corner = newIndex[corner];
    }
  }
  return part;
}

// --- paths along edges -------------------------------------------------------------------------------------

void connect(Links& links, const std::vector<Vector3d>& points, std::uint32_t a, std::uint32_t b) {
  const double length = (points[a] - points[b]).norm();
  links[a].push_back({b, length});
  links[b].push_back({a, length});
}

Links edgeLinks(const std::vector<Vector3d>& points, const std::vector<Triangle>& triangles) {
  Links links(points.size());
  for (const Edge& edge : uniqueEdges(triangles)) connect(links, points, edge[0], edge[1]);
  return links;
}

std::vector<double> shortestPaths(const Links& links, std::uint32_t from, double maxLength) {
  using Arrival = std::pair<double, std::uint32_t>;
  std::priority_queue<Arrival, std::vector<Arrival>, std::greater<>> front;
  std::vector<double> length(links.size(), maxLength);
  length[from] = 0.0;
  front.push({0.0, from});
  while (!front.empty()) {
    const auto [distance, point] = front.top();
    front.pop();
    if (distance > length[point]) continue;
    for (const Link& link : links[point]) {
      if (distance + link.length >= length[link.to]) continue;
      length[link.to] = distance + link.length;
      front.push({length[link.to], link.to});
    }
  }
  return length;
}

// --- triangles and surfaces --------------------------------------------------------------------------------

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

double extent(const TriangleMesh& mesh) {
  Eigen::AlignedBox3d box;
  for (const Triangle& t : mesh.triangles)
    for (const std::uint32_t corner : t) box.extend(mesh.positions[corner]);
  return box.isEmpty() ? 0.0 : box.sizes().maxCoeff();
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

// --- nearest points ---------------------------------------------------------------------------------------

namespace {

/// Returns a position on an edge, from 0 at the first to 1 at the second corner. `numerator` and `rest` are
/// the distances from the corners along the edge, times the edge's length.
double edgeFraction(double numerator, double rest) {
  const double sum = numerator + rest;
  return sum > 0.0 ? numerator / sum : 0.0;
}

}  // namespace

Vector3d nearestBarycentric(const TriangleCorners& t, const Vector3d& p) {
  const Vector3d ab = t[1] - t[0], ac = t[2] - t[0];
  const Vector3d ap = p - t[0], bp = p - t[1], cp = p - t[2];
  const double d1 = ab.dot(ap), d2 = ac.dot(ap);
  if (d1 <= 0.0 && d2 <= 0.0) return {1.0, 0.0, 0.0};
  const double d3 = ab.dot(bp), d4 = ac.dot(bp);
  if (d3 >= 0.0 && d4 <= d3) return {0.0, 1.0, 0.0};
  const double d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d6 >= 0.0 && d5 <= d6) return {0.0, 0.0, 1.0};

  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0) {
    const double v = edgeFraction(d1, -d3);
    return {1.0 - v, v, 0.0};
  }
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0) {
    const double w = edgeFraction(d2, -d6);
    return {1.0 - w, 0.0, w};
  }
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0) {
    const double w = edgeFraction(d4 - d3, d5 - d6);
    return {0.0, 1.0 - w, w};
  }
  const double v = vb / (va + vb + vc), w = vc / (va + vb + vc);
  return {1.0 - v - w, v, w};
}

double nearestOnSegment(const Vector3d& from, const Vector3d& to, const Vector3d& p) {
  const Vector3d along = to - from;
  const double squared = along.squaredNorm();
  return squared > 0.0 ? std::clamp(along.dot(p - from) / squared, 0.0, 1.0) : 0.0;
}

SegmentPair nearestOnSegments(const Vector3d& a0, const Vector3d& a1, const Vector3d& b0,
                              const Vector3d& b1) {
  const Vector3d u = a1 - a0, v = b1 - b0, w = a0 - b0;
  const double uu = u.squaredNorm(), vv = v.squaredNorm(), uv = u.dot(v), uw = u.dot(w), vw = v.dot(w);
  const double determinant = uu * vv - uv * uv;
  double s = determinant > 0.0 ? std::clamp((uv * vw - vv * uw) / determinant, 0.0, 1.0) : 0.0;
  const double t = vv > 0.0 ? std::clamp((uv * s + vw) / vv, 0.0, 1.0) : 0.0;
  s = uu > 0.0 ? std::clamp((uv * t - uw) / uu, 0.0, 1.0) : 0.0;
  return {s, t};
}

}  // namespace limber
