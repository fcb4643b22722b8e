// SPDX-License-Identifier: Zlib
// Computes the edges, the components and the geometry of surfaces, finds nearest points, and orients surfaces
// outward: closed components by their volume, and the patches of open or broken meshes by their shape.

#include "mesh/surface.h"

#include <cmath>
#include <functional>
#include <queue>
#include <tuple>

namespace limber {

using Eigen::Vector3d;

namespace {

bool isBefore(const Side& a, const Side& b) {
  return std::tie(a.edge, a.triangle, a.corner) < std::tie(b.edge, b.triangle, b.corner);
}

/// Counting sorts take memory for all indices: sides with more than this many times as many are sorted by
/// comparisons.
constexpr std::size_t kMostIndicesPerSide = 4;

/// Sorts sides by their first points, whose indices are `low` and, at most `range` in all, those above. Sides
/// of one first point, which are few, are then sorted by comparisons.
void sortByFirstPoint(std::vector<Side>& sides, std::uint32_t low, std::size_t range) {
  std::vector<std::size_t> end(range + 1, 0);
  for (const Side& side : sides) ++end[side.edge[0] - low + 1];
  std::partial_sum(end.begin(), end.end(), end.begin());
  std::vector<Side> sorted(sides.size());
  for (const Side& side : sides) sorted[end[side.edge[0] - low]++] = side;
  std::size_t first = 0;
  for (std::size_t point = 0; point < range; ++point) {
    const auto begin = sorted.begin();
    std::sort(begin + static_cast<std::ptrdiff_t>(first), begin + static_cast<std::ptrdiff_t>(end[point]),
              isBefore);
    first = end[point];
  }
  sides = std::move(sorted);
}

}  // namespace

std::vector<Side> sortedSides(const std::vector<Triangle>& triangles) {
  std::vector<Side> sides;
  sides.reserve(3 * triangles.size());
  std::uint32_t low = kNoPoint, high = 0;
  for (std::uint32_t t = 0; t < triangles.size(); ++t)
    for (std::uint32_t c = 0; c < 3; ++c) {
      sides.push_back({edgeBetween(triangles[t][c], triangles[t][(c + 1) % 3]), t, c});
      low = std::min(low, sides.back().edge[0]);
      high = std::max(high, sides.back().edge[0]);
    }
  if (sides.empty()) return sides;
  if (const std::size_t range = std::size_t{high} - low + 1; range <= kMostIndicesPerSide * sides.size())
    sortByFirstPoint(sides, low, range);
  else
    std::sort(sides.begin(), sides.end(), isBefore);
  return sides;
}

std::vector<Edge> uniqueEdges(const std::vector<Triangle>& triangles) {
  std::vector<Edge> edges;
  forEachEdge(triangles, [&](const Side* sides, std::size_t) { edges.push_back(sides->edge); });
  return edges;
}

EdgeDefects findEdgeDefects(const std::vector<Triangle>& triangles) {
  EdgeDefects defects;
  const auto isUpward = [&](const Side& s) { return triangles[s.triangle][s.corner] == s.edge[0]; };
  forEachEdge(triangles, [&](const Side* sides, std::size_t uses) {
    if (uses == 1) ++defects.open;
    if (uses > 2) ++defects.nonManifold;
    if (uses == 2 && isUpward(sides[0]) == isUpward(sides[1])) ++defects.inconsistent;
  });
  return defects;
}

void setEdgeDefects(MeshReport& report, const std::vector<Triangle>& triangles) {
  const EdgeDefects defects = findEdgeDefects(triangles);
  report.openEdges = defects.open;
  report.nonManifoldEdges = defects.nonManifold;
  report.inconsistentEdges = defects.inconsistent;
}

SurfaceComponents findComponents(std::size_t points, const std::vector<Triangle>& triangles) {
  DisjointSets sets(points);
  for (const Triangle& t : triangles) {
    sets.join(t[0], t[1]);
    sets.join(t[0], t[2]);
  }
  Renumbering numbers(points);
  SurfaceComponents components;
  for (const Triangle& t : triangles) components.ofTriangle.push_back(numbers(sets.root(t[0])));
  components.count = numbers.kept().size();
  return components;
}

std::vector<std::vector<Triangle>> trianglesOfPieces(std::size_t points,
                                                     const std::vector<Triangle>& triangles) {
  const SurfaceComponents pieces = findComponents(points, triangles);
  std::vector<std::vector<Triangle>> result(pieces.count);
  for (std::size_t t = 0; t < triangles.size(); ++t) result[pieces.ofTriangle[t]].push_back(triangles[t]);
  return result;
}

TriangleMesh meshOf(std::vector<Vector3d> points, std::vector<Triangle> triangles) {
  return {std::move(points), {}, {}, std::move(triangles)};
}

TriangleMesh partOf(const TriangleMesh& mesh, std::vector<Triangle> triangles) {
  Renumbering numbers(mesh.positions.size());
  for (Triangle& t : triangles) t = numbers(t);
  return {chosen(mesh.positions, numbers.kept()), chosen(mesh.normals, numbers.kept()),
          chosen(mesh.uvs, numbers.kept()), std::move(triangles)};
}

// --- paths along edges -------------------------------------------------------------------------------------

void connect(Links& links, const std::vector<Vector3d>& points, std::uint32_t a, std::uint32_t b) {
  const double length = (points[a] - points[b]).norm();
  links[a].push_back({b, length});
  links[b].push_back({a, length});
}

Links edgeLinks(const std::vector<Vector3d>& points, const std::vector<Edge>& edges) {
  Links links(points.size());
  for (const Edge& edge : edges) connect(links, points, edge[0], edge[1]);
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

Eigen::AlignedBox3d boxOf(const std::vector<Vector3d>& points) {
  Eigen::AlignedBox3d box;
  for (const Vector3d& p : points) box.extend(p);
  return box;
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
  return points.empty() ? 0.0 : boxOf(points).sizes().maxCoeff();
}

double areaOf(const std::vector<Vector3d>& points, const std::vector<Triangle>& triangles) {
  double area = 0.0;
  for (const Triangle& t : triangles) area += areaVector(points, t).norm();
  return area;
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
    const Vector3d vector = areaVector(points, t);
    for (const std::uint32_t corner : t) normals[corner] += vector;
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

// --- the orientation of closed components ------------------------------------------------------------------

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
  for (const Triangle& t : outer.triangles) angle += solidAngle(cornersOf(points, t), corner);
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
  flipped.reserve(parts.size());
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

// --- the orientation of patches ----------------------------------------------------------------------------

namespace {

/// A patch is a set of triangles that are joined by edges of two triangles. It can be oriented consistently,
/// except for surfaces with one side (Moebius strips).
struct Patches {
  std::vector<std::uint32_t> ofTriangle;  ///< #triangles
  std::vector<char> flipped;  ///< #triangles: against the first triangle of its patch in the orientation
  std::uint32_t count = 0;
};

/// Returns for each triangle the neighbours across its three edges, or kNoPoint where the edge is open or of
/// more than two triangles.
std::vector<std::array<std::uint32_t, 3>> neighboursOf(const std::vector<Triangle>& triangles) {
  std::vector<std::array<std::uint32_t, 3>> neighbours(triangles.size(), {kNoPoint, kNoPoint, kNoPoint});
  forEachEdge(triangles, [&](const Side* sides, std::size_t count) {
    if (count != 2) return;
    neighbours[sides[0].triangle][sides[0].corner] = sides[1].triangle;
    neighbours[sides[1].triangle][sides[1].corner] = sides[0].triangle;
  });
  return neighbours;
}

/// Returns whether the triangle runs from `a` to `b` along one of its sides.
bool runsAlong(const Triangle& t, std::uint32_t a, std::uint32_t b) {
  return (t[0] == a && t[1] == b) || (t[1] == a && t[2] == b) || (t[2] == a && t[0] == b);
}

Patches findPatches(const std::vector<Triangle>& triangles) {
  const auto neighbours = neighboursOf(triangles);
  Patches patches{std::vector<std::uint32_t>(triangles.size(), kNoPoint),
                  std::vector<char>(triangles.size(), 0), 0};
  std::vector<std::uint32_t> front;
  for (std::uint32_t seed = 0; seed < triangles.size(); ++seed) {
    if (patches.ofTriangle[seed] != kNoPoint) continue;
    patches.ofTriangle[seed] = patches.count;
    front.assign(1, seed);
    while (!front.empty()) {
      const std::uint32_t t = front.back();
      front.pop_back();
      for (std::uint32_t c = 0; c < 3; ++c) {
        const std::uint32_t other = neighbours[t][c];
        if (other == kNoPoint || patches.ofTriangle[other] != kNoPoint) continue;
        const bool against = runsAlong(triangles[other], triangles[t][c], triangles[t][(c + 1) % 3]);
        patches.ofTriangle[other] = patches.count;
        patches.flipped[other] = static_cast<char>(patches.flipped[t] != static_cast<char>(against));
        front.push_back(other);
      }
    }
    ++patches.count;
  }
  return patches;
}

/// A patch in the orientation of its first triangle.
struct PatchShape {
  double area = 0.0, agreeing = 0.0;  ///< m^2; of triangles that the mesh orients like this
  Vector3d moment = Vector3d::Zero(), vector = Vector3d::Zero();  ///< sums of area x centroid, area vectors
  double flux = 0.0;  ///< m^3, a third of the sum of centroid . area vector, about the origin

  Vector3d centre() const { return area > 0.0 ? Vector3d(moment / area) : Vector3d::Zero(); }
  double volumeAbout(const Vector3d& p) const { return flux - p.dot(vector) / 3.0; }
};

/// A patch with more than this sphericity, 36 pi V^2 / A^3, is curved enough that its own volume shows its
/// outside: a ball has 1, half a ball without its base 0.25, a shallow dish less.
constexpr double kCurved = 0.02;

/// Returns whether a patch must be turned against the orientation of its first triangle: curved patches
/// enclose a positive volume with their middle, the others keep the orientation of most of their area if the
/// mesh gives them one, and else face away from the middle of the mesh.
bool facesInward(const PatchShape& patch, const Vector3d& middle) {
  const double own = patch.volumeAbout(patch.centre());
  if (36.0 * kPi * own * own > kCurved * patch.area * patch.area * patch.area) return own < 0.0;
  const bool isConsistent = patch.agreeing <= 0.0 || patch.agreeing >= patch.area;
  return isConsistent ? patch.agreeing <= 0.0 : patch.volumeAbout(middle) < 0.0;
}

/// Returns the patches in the orientation of their first triangles, and the middle of the mesh, by area.
std::vector<PatchShape> measurePatches(const std::vector<Vector3d>& points,
                                       const std::vector<Triangle>& triangles, const Patches& patches,
                                       Vector3d& middleOfMesh) {
  std::vector<PatchShape> shapes(patches.count);
  Vector3d moment = Vector3d::Zero();
  double area = 0.0;
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    const double sign = patches.flipped[t] ? -1.0 : 1.0;
    const Vector3d vector = sign * areaVector(points, triangles[t]), middle = centroid(points, triangles[t]);
    PatchShape& shape = shapes[patches.ofTriangle[t]];
    shape.area += vector.norm();
    shape.agreeing += patches.flipped[t] ? 0.0 : vector.norm();
    shape.moment += vector.norm() * middle;
    shape.vector += vector;
    shape.flux += middle.dot(vector) / 3.0;
    moment += vector.norm() * middle;
    area += vector.norm();
  }
  if (area > 0.0) middleOfMesh = moment / area;
  return shapes;
}

}  // namespace

std::vector<bool> patchesFacingInward(const std::vector<Vector3d>& points,
                                      const std::vector<Triangle>& triangles) {
  const Patches patches = findPatches(triangles);
  Vector3d middle = Vector3d::Zero();
  const std::vector<PatchShape> shapes = measurePatches(points, triangles, patches, middle);
  std::vector<bool> marked;
  for (std::size_t t = 0; t < triangles.size(); ++t)
    marked.push_back((patches.flipped[t] != 0) != facesInward(shapes[patches.ofTriangle[t]], middle));
  return marked;
}

}  // namespace limber
