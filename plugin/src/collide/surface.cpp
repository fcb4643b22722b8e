// SPDX-License-Identifier: Zlib

// This file builds the topology of a surface, tests directions with the normal cones of its edges and
// vertices, fits its motion relative to another surface, and searches its tree of boxes.

#include "collide/surface.h"

#include <Eigen/LU>

#include <cmath>

namespace limber {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Vector3d;

/// Share of a triangle's shortest side by which a vertex may be behind it.
constexpr double kDepthShare = 0.25;
/// Edges of a rigid shape with a smaller fold (about rad) are flat.
constexpr double kFlatRigidFold = 0.02;

template <std::size_t N>
std::string checkIndices(const char* kind, std::size_t item, const std::array<std::uint32_t, N>& corners,
                         Eigen::Index points) {
  const std::string name = kind + (" " + std::to_string(item));
  for (std::size_t i = 0; i < N; ++i) {
    if (corners[i] >= points)
      return name + " uses point " + std::to_string(corners[i]) + " of " + std::to_string(points);
    if (N > 1 && corners[i] == corners[(i + 1) % N])
      return name + " has point " + std::to_string(corners[i]) + " twice";
  }
  return {};
}

std::string check(const Points& rest, const SurfaceFeatures& features) {
  std::string reason;
  for (Eigen::Index i = 0; i < rest.cols() && reason.empty(); ++i)
    if (!rest.col(i).allFinite()) reason = "the position of point " + std::to_string(i) + " is not finite";
  for (std::size_t i = 0; i < features.triangles.size() && reason.empty(); ++i)
    reason = checkIndices("triangle", i, features.triangles[i], rest.cols());
  for (std::size_t i = 0; i < features.segments.size() && reason.empty(); ++i)
    reason = checkIndices("segment", i, features.segments[i], rest.cols());
  for (std::size_t i = 0; i < features.vertices.size() && reason.empty(); ++i)
    reason = checkIndices("vertex", i, std::array<std::uint32_t, 1>{features.vertices[i]}, rest.cols());
  return reason;
}

/// Returns the sorted edges of the triangles, then the segments that are not among them.
std::vector<Edge> allEdges(const SurfaceFeatures& features) {
  std::vector<Edge> edges = uniqueEdges(features.triangles), loose;
  for (const Edge& s : features.segments) {
    const Edge edge = edgeBetween(s[0], s[1]);
    if (!std::binary_search(edges.begin(), edges.end(), edge)) loose.push_back(edge);
  }
  sortUnique(loose);
  edges.insert(edges.end(), loose.begin(), loose.end());
  return edges;
}

/// Returns the edges of each triangle: edge k from corner k to the next one.
std::vector<Triangle> edgesOfTriangles(const SurfaceTopology& t, std::size_t triangleEdges) {
  const auto begin = t.edges.begin(), end = begin + static_cast<std::ptrdiff_t>(triangleEdges);
  std::vector<Triangle> edgesOf(t.triangles.size());
  for (std::size_t i = 0; i < t.triangles.size(); ++i)
    for (std::size_t k = 0; k < 3; ++k) {
      const Edge edge = edgeBetween(t.triangles[i][k], t.triangles[i][(k + 1) % 3]);
      edgesOf[i][k] = static_cast<std::uint32_t>(std::lower_bound(begin, end, edge) - begin);
    }
  return edgesOf;
}

template <class Items>
IndexLists listsAround(Eigen::Index points, const Items& items) {
  IndexLists lists;
  lists.first.assign(static_cast<std::size_t>(points) + 1, 0);
  for (const auto& item : items)
    for (const std::uint32_t corner : item) ++lists.first[corner + 1];
  for (std::size_t i = 1; i < lists.first.size(); ++i) lists.first[i] += lists.first[i - 1];
  lists.items.resize(lists.first.back());
  std::vector<std::uint32_t> next(lists.first.begin(), lists.first.end() - 1);
  for (std::size_t i = 0; i < items.size(); ++i)
    for (const std::uint32_t corner : items[i]) lists.items[next[corner]++] = static_cast<std::uint32_t>(i);
  return lists;
}

/// Returns for each triangle whether it is one-sided: solid behind it. A piece is closed if each of its edges
/// belongs to two triangles that run along it in opposite directions.
std::vector<std::uint8_t> findOneSided(const SurfaceTopology& t, const std::vector<Triangle>& edgesOf,
                                       Solid solid) {
  const SurfaceComponents pieces = findComponents(static_cast<std::size_t>(t.rest.cols()), t.triangles);
  std::vector<int> uses(t.edges.size(), 0), balance(t.edges.size(), 0);
  for (std::size_t i = 0; i < edgesOf.size(); ++i)
    for (std::size_t k = 0; k < 3; ++k) {
      ++uses[edgesOf[i][k]];
      balance[edgesOf[i][k]] += t.triangles[i][k] < t.triangles[i][(k + 1) % 3] ? 1 : -1;
    }
  std::vector<std::uint8_t> closed(pieces.count, 1), oneSided;
  for (std::size_t i = 0; i < edgesOf.size(); ++i)
    for (const std::uint32_t edge : edgesOf[i])
      if (uses[edge] != 2 || balance[edge] != 0) closed[pieces.ofTriangle[i]] = 0;
  for (const std::uint32_t piece : pieces.ofTriangle)
    oneSided.push_back(solid == Solid::AllPieces || (solid == Solid::ClosedPieces && closed[piece]));
  return oneSided;
}

void setEdgeTriangles(SurfaceTopology& t, const std::vector<Triangle>& edgesOf) {
  t.edgeTriangles.assign(t.edges.size(), {kNoFeature, kNoFeature});
  for (std::uint32_t i = 0; i < edgesOf.size(); ++i)
    for (const std::uint32_t edge : edgesOf[i]) {
      auto& pair = t.edgeTriangles[edge];
      if (pair[1] == kNoFeature) pair[pair[0] == kNoFeature ? 0 : 1] = i;
    }
}

Vector3d restNormal(const SurfaceTopology& t, std::uint32_t triangle) {
  const auto& [a, b, c] = t.triangles[triangle];
  return (t.rest.col(b) - t.rest.col(a)).cross(t.rest.col(c) - t.rest.col(a)).normalized();
}

double shortestSide(const SurfaceTopology& t, const Triangle& corners) {
  const auto [a, b, c] = corners;
  return std::min({(t.rest.col(a) - t.rest.col(b)).norm(), (t.rest.col(b) - t.rest.col(c)).norm(),
                   (t.rest.col(c) - t.rest.col(a)).norm()});
}

/// Whether no object can touch the edge from outside.
bool isUnreachable(const SurfaceTopology& t, std::uint32_t edge) {
  const auto [first, second] = t.edgeTriangles[edge];
  if (second == kNoFeature) return false;
  const Vector3d n0 = restNormal(t, first), n1 = restNormal(t, second);
  if ((n0 - n1).norm() < kFlatRigidFold) return true;
  if (!t.oneSided[first] || !t.oneSided[second]) return false;
  std::uint32_t opposite = 0;
  for (const std::uint32_t corner : t.triangles[second])
    if (corner != t.edges[edge][0] && corner != t.edges[edge][1]) opposite = corner;
  return n0.dot(t.rest.col(opposite) - t.rest.col(t.edges[edge][0])) > 0.0;
}

/// Adds elements. The first element with a vertex or an edge becomes its owner.
class ElementList {
 public:
  explicit ElementList(SurfaceTopology& t)
      : t_(t), vertexOwned_(static_cast<std::size_t>(t.rest.cols())), edgeOwned_(t.edges.size()) {}

  void excludeEdge(std::uint32_t edge) { edgeOwned_[edge] = true; }

  void add(const Triangle& corners, const Triangle& edges, std::uint32_t triangle = kNoFeature) {
    SurfaceElement element{corners, triangle};
    for (std::size_t k = 0; k < 3; ++k) {
      if (edges[k] != kNoFeature && !edgeOwned_[edges[k]]) element.edges[k] = edges[k];
      if (edges[k] != kNoFeature) edgeOwned_[edges[k]] = true;
      if (vertexOwned_[corners[k]]) continue;
      element.vertices[k] = corners[k];
      t_.vertices.push_back(corners[k]);
      vertexOwned_[corners[k]] = true;
    }
    t_.elements.push_back(element);
  }
  void addVertex(std::uint32_t v) {
    if (!vertexOwned_[v]) add({v, v, v}, {kNoFeature, kNoFeature, kNoFeature});
  }

 private:
  SurfaceTopology& t_;
  std::vector<bool> vertexOwned_, edgeOwned_;
};

void addElements(SurfaceTopology& t, const std::vector<Triangle>& edgesOf, std::size_t triangleEdges,
                 const SurfaceFeatures& features) {
  ElementList elements(t);
  for (std::uint32_t e = 0; features.rigid && e < triangleEdges; ++e)
    if (isUnreachable(t, e)) elements.excludeEdge(e);
  for (std::uint32_t i = 0; i < t.triangles.size(); ++i) elements.add(t.triangles[i], edgesOf[i], i);
  for (auto e = static_cast<std::uint32_t>(triangleEdges); e < t.edges.size(); ++e)
    elements.add({t.edges[e][0], t.edges[e][1], t.edges[e][1]}, {e, kNoFeature, kNoFeature});
  for (const std::uint32_t v : features.vertices) elements.addVertex(v);
}

}  // namespace

Result<SurfaceTopology> makeSurfaceTopology(const Points& rest, const SurfaceFeatures& features) {
  const std::string reason = check(rest, features);
  if (!reason.empty()) return Error{reason};
  SurfaceTopology t;
  t.rest = rest;
  t.triangles = features.triangles;
  t.edges = allEdges(features);
  const std::size_t triangleEdges = uniqueEdges(features.triangles).size();
  const std::vector<Triangle> edgesOf = edgesOfTriangles(t, triangleEdges);
  setEdgeTriangles(t, edgesOf);
  t.oneSided = findOneSided(t, edgesOf, features.solid);
  for (const Triangle& corners : t.triangles) t.depthLimit.push_back(kDepthShare * shortestSide(t, corners));
  for (const Edge& e : t.edges)
    t.featureSize += (rest.col(e[0]) - rest.col(e[1])).norm() / double(t.edges.size());
  t.edgesAround = listsAround(rest.cols(), t.edges);
  t.trianglesAround = listsAround(rest.cols(), t.triangles);
  addElements(t, edgesOf, triangleEdges, features);
  t.nodes = makeSurfaceTree(rest, t.elements);
  return t;
}

// --- normal cones ------------------------------------------------------------------------------------------

namespace {

/// Sine: tolerance of a vertex's cone for rounding and for slight deformation of a body.
constexpr double kConeTolerance = 0.01;

/// Returns the unit vector perpendicular to the edge that points into the triangle.
Vector3d inwardFrom(const MovingSurface& surface, double time, std::uint32_t edge, std::uint32_t triangle) {
  const Edge& ends = surface.topology->edges[edge];
  const Vector3d from = surface.at(ends[0], time), along = (surface.at(ends[1], time) - from).normalized();
  std::uint32_t opposite = ends[0];
  for (const std::uint32_t corner : surface.topology->triangles[triangle])
    if (corner != ends[0] && corner != ends[1]) opposite = corner;
  const Vector3d to = surface.at(opposite, time) - from;
  return (to - along * along.dot(to)).normalized();
}

}  // namespace

Vector3d normalAt(const MovingSurface& surface, double time, std::uint32_t triangle) {
  return normalOf<3>(featureOf<3>(surface, surface.topology->triangles[triangle]).at(time));
}

bool isInNormalCone(const MovingSurface& surface, double time, std::uint32_t edge, const Vector3d& outward,
                    const ConeTolerance& tolerance) {
  const auto [first, second] = surface.topology->edgeTriangles[edge];
  if (first == kNoFeature) return true;
  const Vector3d in0 = inwardFrom(surface, time, edge, first);
  if (second == kNoFeature) return outward.dot(in0) <= tolerance.sine;
  const Vector3d in1 = inwardFrom(surface, time, edge, second);
  const double fold = (in0 + in1).norm();
  const bool isFlat = fold < tolerance.flatFold;
  if (isFlat ? !tolerance.flatToo : outward.dot(in0 + in1) >= 0.0) return false;
  const double maxSine = isFlat ? tolerance.sine : std::min(tolerance.sine, 0.25 * fold);
  if (outward.dot(in0) > maxSine || outward.dot(in1) > maxSine) return false;
  if (!surface.topology->oneSided[first] || !surface.topology->oneSided[second]) return true;
  return outward.dot(normalAt(surface, time, first) + normalAt(surface, time, second)) > 0.0;
}

bool isFlatAlong(const MovingSurface& surface, std::uint32_t edge, const Vector3d& normal) {
  constexpr double kPressedFold = 0.05 * kFlatFold, kSine = 0.1;
  const SurfaceTopology& t = *surface.topology;
  const auto [first, second] = t.edgeTriangles[edge];
  if (first == kNoFeature || second == kNoFeature) return false;
  for (const double time : {0.0, 1.0}) {
    const Vector3d in0 = inwardFrom(surface, time, edge, first),
                   in1 = inwardFrom(surface, time, edge, second);
    if ((in0 + in1).squaredNorm() >= kPressedFold * kPressedFold || std::abs(normal.dot(in0)) >= kSine)
      return false;
  }
  return (restNormal(t, first) - restNormal(t, second)).squaredNorm() < kFlatFold * kFlatFold;
}

bool facesOutward(const MovingSurface& surface, double time, std::uint32_t vertex, const Vector3d& outward,
                  double cosine) {
  const SurfaceTopology& t = *surface.topology;
  const auto faces = [&](std::uint32_t i) {
    return !t.oneSided[i] || outward.dot(normalAt(surface, time, i)) > cosine;
  };
  const std::uint32_t *begin = t.trianglesAround.begin(vertex), *end = t.trianglesAround.end(vertex);
  return begin == end || std::any_of(begin, end, faces);
}

bool isInVertexCone(const MovingSurface& surface, double time, std::uint32_t vertex,
                    const Vector3d& outward) {
  const SurfaceTopology& t = *surface.topology;
  const Vector3d from = surface.at(vertex, time);
  for (const std::uint32_t* e = t.edgesAround.begin(vertex); e != t.edgesAround.end(vertex); ++e) {
    const std::uint32_t other = t.edges[*e][t.edges[*e][0] == vertex ? 1 : 0];
    const Vector3d along = surface.at(other, time) - from;
    if (outward.dot(along) > kConeTolerance * along.norm()) return false;
  }
  return facesOutward(surface, time, vertex, outward);
}

// --- relative motion ---------------------------------------------------------------------------------------

namespace {

/// Share of the trace of I that is added to its diagonal: points on a line do not tell their turn about it.
constexpr double kRegular = 1e-9;

Vector3d turnOf(const PointColumns& positions, const PointColumns& velocities, const SurfaceMotion& m) {
  Matrix3d second = Matrix3d::Zero();
  Vector3d moment = Vector3d::Zero();
  for (Index i = 0; i < velocities.cols(); ++i) {
    const Vector3d r = positions.col(i) - m.centre;
    second.noalias() += r * r.transpose();
    moment += r.cross(Vector3d(velocities.col(i) - m.mean));
  }
  const double trace = second.trace();
  if (!(trace > 0.0)) return Vector3d::Zero();
  return (Matrix3d::Identity() * (trace * (1.0 + kRegular)) - second).inverse() * moment;
}

}  // namespace

SurfaceMotion fittedMotion(const PointColumns& positions, const PointColumns& velocities) {
  SurfaceMotion m;
  const Index count = velocities.cols();
  if (count == 0) return m;
  for (Index i = 0; i < count; ++i) m.centre += positions.col(i), m.mean += velocities.col(i);
  m.centre /= static_cast<double>(count);
  m.mean /= static_cast<double>(count);
  m.turn = turnOf(positions, velocities, m);
  double radius = 0.0, spread = 0.0, deformation = 0.0;
  for (Index i = 0; i < count; ++i) {
    const Vector3d r = positions.col(i) - m.centre, v = velocities.col(i) - m.mean;
    radius = std::max(radius, r.squaredNorm());
    spread = std::max(spread, v.squaredNorm());
    deformation = std::max(deformation, (v - m.turn.cross(r)).squaredNorm());
  }
  m.radius = std::sqrt(radius);
  m.spread = std::sqrt(spread);
  m.deformation = std::sqrt(deformation);
  return m;
}

SurfaceMotion fittedMotion(const PointView& points, Index count) {
  const Eigen::Stride<Eigen::Dynamic, Eigen::Dynamic> stride(points.pointStride, points.axisStride);
  using Columns = Eigen::Map<const Points, 0, Eigen::Stride<Eigen::Dynamic, Eigen::Dynamic>>;
  return fittedMotion(Columns(points.position, 3, count, stride), Columns(points.velocity, 3, count, stride));
}

RelativeMotion relativeMotion(const SurfaceMotion& a, const SurfaceMotion& b, MotionFrame frame) {
  if (frame == MotionFrame::Still) return {a.mean - b.mean, a.spread + b.spread, 0.0};
  const Vector3d between = a.centre - b.centre;
  const bool atA = frame == MotionFrame::AtA;
  return {a.mean - b.mean - (atA ? b.turn : a.turn).cross(between),
          (a.turn - b.turn).norm() * (atA ? a.radius : b.radius) + a.deformation + b.deformation,
          std::max(a.turn.norm(), b.turn.norm())};
}

MotionFrame calmestFrame(const SurfaceMotion& a, const SurfaceMotion& b, double featureSize) {
  const auto speed = [&](MotionFrame frame) { return relativeMotion(a, b, frame).speed(featureSize); };
  return std::min({MotionFrame::Still, MotionFrame::AtA, MotionFrame::AtB},
                  [&](MotionFrame x, MotionFrame y) { return speed(x) < speed(y); });
}

// --- the tree of boxes -------------------------------------------------------------------------------------

namespace {

/// Sorts elements along the longest side of the box of their centres. A full sort, not nth_element: the tree
/// does not depend on the standard library.
void sortAlongBox(std::uint32_t* begin, std::uint32_t* end, const std::vector<Vector3d>& centres) {
  Eigen::AlignedBox3d box;
  std::for_each(begin, end, [&](std::uint32_t i) { box.extend(centres[i]); });
  Eigen::Index axis = 0;
  box.sizes().maxCoeff(&axis);
  std::sort(begin, end, [&](std::uint32_t i, std::uint32_t j) {
    const double x = centres[i][axis], y = centres[j][axis];
    return x != y ? x < y : i < j;
  });
}

SweptBox pointBox(const MovingSurface& surface, Eigen::Index point) {
  Eigen::Array4d start, motion;
  start << surface.position->col(point), 0.0;
  motion << surface.motion->col(point), 0.0;
  const Eigen::Array4d end = start + motion, radius(surface.radius, surface.radius, surface.radius, 0.0);
  return {start.min(end) - radius, start.max(end) + radius};
}

SweptBox elementBox(const MovingSurface& surface, const SurfaceElement& element,
                    const std::vector<SweptBox>& points) {
  const auto& [a, b, c] = element.corners;
  SweptBox box = merged(merged(points[a], points[b]), points[c]);
  const std::uint32_t triangle = element.triangle;
  if (triangle == kNoFeature || !surface.topology->oneSided[triangle]) return box;
  const Vector3d first = surface.position->col(a);
  const Vector3d area = (surface.position->col(b) - first).cross(surface.position->col(c) - first);
  const double length = area.norm();
  if (length == 0.0) return box;
  Eigen::Array4d depth(area.x(), area.y(), area.z(), 0.0);
  depth *= surface.topology->depthLimit[triangle] / length;
  box.low -= depth.max(0.0);
  box.high -= depth.min(0.0);
  return box;
}

bool isLeaf(const SurfaceNode& node) { return node.element != kNoFeature; }

double sizeOf(const SweptBox& box) { return (box.high - box.low).maxCoeff(); }

/// m^2
double squaredDistance(const SweptBox& box, const Eigen::Array4d& point) {
  return (box.low - point).max(point - box.high).max(0.0).matrix().squaredNorm();
}

/// Replaces a pair of nodes by the pairs with the children of the larger node.
void descend(const MovingSurface& a, const MovingSurface& b, std::uint32_t i, std::uint32_t j,
             LeafPairs& waiting) {
  const SurfaceNode &na = a.topology->nodes[i], &nb = b.topology->nodes[j];
  if (isLeaf(nb) || (!isLeaf(na) && sizeOf(a.boxes->nodes[i]) >= sizeOf(b.boxes->nodes[j]))) {
    waiting.emplace_back(na.child + 1, j);
    waiting.emplace_back(na.child, j);
  } else {
    waiting.emplace_back(i, nb.child + 1);
    waiting.emplace_back(i, nb.child);
  }
}

/// Replaces a pair of equal nodes by the pairs of its children.
void descendIntoOne(const SurfaceNode& node, LeafPairs& waiting) {
  if (isLeaf(node)) return;
  waiting.emplace_back(node.child + 1, node.child + 1);
  waiting.emplace_back(node.child, node.child + 1);
  waiting.emplace_back(node.child, node.child);
}

/// Calls visit(i, j) for the pairs of leaves within `margin` of each other, until it returns false.
template <class Visit>
void forEachNear(const MovingSurface& a, const MovingSurface& b, double margin, LeafPairs& waiting,
                 Visit visit) {
  const bool self = &a == &b;
  const std::vector<SurfaceNode>&nodesA = a.topology->nodes, &nodesB = b.topology->nodes;
  waiting.clear();
  if (!nodesA.empty() && !nodesB.empty()) waiting.emplace_back(0, 0);
  while (!waiting.empty()) {
    const auto [i, j] = waiting.back();
    waiting.pop_back();
    if (self && i == j) {
      descendIntoOne(nodesA[i], waiting);
    } else if (separation(a.boxes->nodes[i], b.boxes->nodes[j]) <= margin) {
      if (!isLeaf(nodesA[i]) || !isLeaf(nodesB[j]))
        descend(a, b, i, j, waiting);
      else if (!visit(i, j))
        return;
    }
  }
}

/// Returns the sum of the normals around a vertex or an edge or of a triangle (where no weight is 0), each
/// weighted with its angle there. With it the sign of the distance is the same for all triangles that share
/// the nearest point (Baerentzen, Aanaes 2005).
Vector3d pseudonormal(const MovingSurface& surface, std::uint32_t triangle, const Vector3d& barycentric) {
  const SurfaceTopology& t = *surface.topology;
  const Triangle& corners = t.triangles[triangle];
  Eigen::Index largest = 0;
  barycentric.maxCoeff(&largest);
  const std::uint32_t anchor = corners[static_cast<std::size_t>(largest)];
  const bool atVertex = (barycentric.array() > 0.0).count() == 1;
  Vector3d sum = Vector3d::Zero();
  for (const std::uint32_t* i = t.trianglesAround.begin(anchor); i != t.trianglesAround.end(anchor); ++i) {
    const Triangle& other = t.triangles[*i];
    const auto find = [&](std::uint32_t v) { return std::find(other.begin(), other.end(), v); };
    bool around = true;
    for (std::size_t k = 0; k < 3; ++k)
      around =
          around && (barycentric[static_cast<Eigen::Index>(k)] <= 0.0 || find(corners[k]) != other.end());
    if (!around) continue;
    const auto feature = featureOf<3>(surface, other);
    const auto k = static_cast<Eigen::Index>(find(anchor) - other.begin());
    const Vector3d u = feature.start.col((k + 1) % 3) - feature.start.col(k);
    const Vector3d v = feature.start.col((k + 2) % 3) - feature.start.col(k);
    const double angle = atVertex ? std::atan2(u.cross(v).norm(), u.dot(v)) : 1.0;
    sum += angle * normalOf<3>(feature.start);
  }
  return sum;
}

}  // namespace

std::vector<SurfaceNode> makeSurfaceTree(const Points& rest, const std::vector<SurfaceElement>& elements) {
  struct Range {
    std::size_t node, first, end;
  };
  if (elements.empty()) return {};
  std::vector<Vector3d> centres;
  centres.reserve(elements.size());
  for (const SurfaceElement& e : elements)
    centres.push_back((rest.col(e.corners[0]) + rest.col(e.corners[1]) + rest.col(e.corners[2])) / 3.0);
  std::vector<std::uint32_t> order(elements.size());
  std::iota(order.begin(), order.end(), 0u);
  std::vector<SurfaceNode> nodes(1);
  std::vector<Range> waiting{{0, 0, elements.size()}};
  while (!waiting.empty()) {
    const auto [node, first, end] = waiting.back();
    waiting.pop_back();
    if (end - first == 1) {
      nodes[node].element = order[first];
      continue;
    }
    sortAlongBox(order.data() + first, order.data() + end, centres);
    const std::size_t child = nodes.size(), middle = first + (end - first) / 2;
    nodes[node].child = static_cast<std::uint32_t>(child);
    nodes.resize(child + 2);
    waiting.push_back({child + 1, middle, end});
    waiting.push_back({child, first, middle});
  }
  return nodes;
}

SweptBox sweptBounds(const MovingSurface& surface) {
  SweptBox box;
  Eigen::Array3d low = box.low.head<3>(), high = box.high.head<3>();
  for (const std::uint32_t v : surface.topology->vertices) {
    const Eigen::Array3d start = surface.position->col(v), end = start + surface.motion->col(v).array();
    low = low.min(start).min(end);
    high = high.max(start).max(end);
  }
  box.low << low - surface.radius, 0.0;
  box.high << high + surface.radius, 0.0;
  return box;
}

void fitBoxes(const MovingSurface& surface, SurfaceBoxes& boxes) {
  const SurfaceTopology& t = *surface.topology;
  boxes.points.resize(static_cast<std::size_t>(surface.position->cols()));
  for (std::size_t i = 0; i < boxes.points.size(); ++i)
    boxes.points[i] = pointBox(surface, static_cast<Eigen::Index>(i));
  boxes.vertices = SweptBox();
  for (const std::uint32_t v : t.vertices) boxes.vertices = merged(boxes.vertices, boxes.points[v]);
  boxes.nodes.resize(t.nodes.size());
  for (std::size_t i = t.nodes.size(); i-- > 0;) {
    const SurfaceNode& node = t.nodes[i];
    boxes.nodes[i] = isLeaf(node) ? elementBox(surface, t.elements[node.element], boxes.points)
                                  : merged(boxes.nodes[node.child], boxes.nodes[node.child + 1]);
  }
}

void findNearLeaves(const MovingSurface& a, const MovingSurface& b, double margin, LeafPairs& waiting,
                    LeafPairs& near) {
  const bool self = &a == &b;
  near.clear();
  forEachNear(a, b, margin, waiting, [&](std::uint32_t i, std::uint32_t j) {
    near.push_back(self ? LeafPairs::value_type(std::minmax(i, j)) : LeafPairs::value_type(i, j));
    return true;
  });
}

bool areLeavesNear(const MovingSurface& a, const MovingSurface& b, double margin, LeafPairs& waiting) {
  bool found = false;
  forEachNear(a, b, margin, waiting, [&](std::uint32_t, std::uint32_t) {
    found = true;
    return false;
  });
  return found;
}

NearestOnSurface nearestOnSurface(const MovingSurface& surface, const Vector3d& point, double within) {
  const SurfaceTopology& t = *surface.topology;
  const std::vector<SweptBox>& boxes = surface.boxes->nodes;
  Eigen::Array4d point4;
  point4 << point, 0.0;
  NearestOnSurface nearest;
  double best = within * within;
  std::array<std::uint32_t, kNodeStack> stack{};
  std::size_t waiting = boxes.empty() ? 0 : 1;
  while (waiting > 0) {
    const std::uint32_t i = stack[--waiting];
    if (squaredDistance(boxes[i], point4) > best) continue;
    const SurfaceNode& node = t.nodes[i];
    if (!isLeaf(node)) {
      const bool firstIsNearer =
          squaredDistance(boxes[node.child], point4) <= squaredDistance(boxes[node.child + 1], point4);
      stack[waiting++] = firstIsNearer ? node.child + 1 : node.child;
      stack[waiting++] = firstIsNearer ? node.child : node.child + 1;
      continue;
    }
    const std::uint32_t triangle = t.elements[node.element].triangle;
    if (triangle == kNoFeature) continue;
    const auto corners = featureOf<3>(surface, t.triangles[triangle]).start;
    const Vector3d weights = nearestBarycentric({corners.col(0), corners.col(1), corners.col(2)}, point);
    const double squared = (corners * weights - point).squaredNorm();
    if (squared > best || (squared == best && triangle > nearest.triangle)) continue;
    best = squared;
    nearest.triangle = triangle;
    nearest.barycentric = weights;
  }
  if (nearest.triangle == kNoFeature) return nearest;
  const Vector3d away =
      point - featureOf<3>(surface, t.triangles[nearest.triangle]).start * nearest.barycentric;
  nearest.distance = std::sqrt(best);
  nearest.behind = away.dot(pseudonormal(surface, nearest.triangle, nearest.barycentric)) < 0.0;
  return nearest;
}

}  // namespace limber
