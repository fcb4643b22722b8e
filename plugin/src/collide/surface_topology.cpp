// SPDX-License-Identifier: Zlib
#include "collide/surface.h"

#include "mesh/edges.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <string>

namespace limber {
namespace {

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

Edge sorted(std::uint32_t a, std::uint32_t b) { return {std::min(a, b), std::max(a, b)}; }

/// Returns the sorted edges of the triangles, then the segments that are not among them.
std::vector<Edge> allEdges(const SurfaceFeatures& features) {
  std::vector<Edge> edges = uniqueEdges(features.triangles), loose;
  for (const Edge& s : features.segments) {
    const Edge edge = sorted(s[0], s[1]);
    if (!std::binary_search(edges.begin(), edges.end(), edge)) loose.push_back(edge);
  }
  std::sort(loose.begin(), loose.end());
  loose.erase(std::unique(loose.begin(), loose.end()), loose.end());
  edges.insert(edges.end(), loose.begin(), loose.end());
  return edges;
}

std::uint32_t edgeIndex(const std::vector<Edge>& edges, std::size_t sortedEdges, const Edge& edge) {
  const auto end = edges.begin() + static_cast<std::ptrdiff_t>(sortedEdges);
  return static_cast<std::uint32_t>(std::lower_bound(edges.begin(), end, edge) - edges.begin());
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

/// Returns for each triangle whether it is one-sided. A piece is closed if each of its edges belongs to two
/// triangles that run along it in opposite directions.
std::vector<std::uint8_t> findOneSided(const SurfaceTopology& t, std::size_t triangleEdges, bool outward) {
  const SurfaceComponents pieces = findComponents(static_cast<std::size_t>(t.rest.cols()), t.triangles);
  std::vector<int> uses(triangleEdges, 0), balance(triangleEdges, 0);
  const auto visit = [&](auto&& callback) {
    for (std::size_t i = 0; i < t.triangles.size(); ++i)
      for (std::size_t k = 0; k < 3; ++k) {
        const std::uint32_t from = t.triangles[i][k], to = t.triangles[i][(k + 1) % 3];
        callback(i, edgeIndex(t.edges, triangleEdges, sorted(from, to)), from < to ? 1 : -1);
      }
  };
  visit([&](std::size_t, std::uint32_t edge, int direction) { ++uses[edge], balance[edge] += direction; });
  std::vector<std::uint8_t> closed(pieces.count, 1), oneSided;
  visit([&](std::size_t i, std::uint32_t edge, int) {
    if (uses[edge] != 2 || balance[edge] != 0) closed[pieces.ofTriangle[i]] = 0;
  });
  for (const std::uint32_t piece : pieces.ofTriangle) oneSided.push_back(outward || closed[piece]);
  return oneSided;
}

void setEdgeTriangles(SurfaceTopology& t, std::size_t triangleEdges) {
  t.edgeTriangles.assign(t.edges.size(), {kNoFeature, kNoFeature});
  for (std::uint32_t i = 0; i < t.triangles.size(); ++i)
    for (std::size_t k = 0; k < 3; ++k) {
      const Edge edge = sorted(t.triangles[i][k], t.triangles[i][(k + 1) % 3]);
      auto& pair = t.edgeTriangles[edgeIndex(t.edges, triangleEdges, edge)];
      if (pair[0] == kNoFeature)
        pair[0] = i;
      else if (pair[1] == kNoFeature)
        pair[1] = i;
    }
}

Vector3d restNormal(const SurfaceTopology& t, std::uint32_t triangle) {
  const auto& [a, b, c] = t.triangles[triangle];
  return (t.rest.col(b) - t.rest.col(a)).cross(t.rest.col(c) - t.rest.col(a)).normalized();
}

double shortestSide(const SurfaceTopology& t, const Triangle& corners) {
  const auto length = [&](std::uint32_t a, std::uint32_t b) {
    return (t.rest.col(a) - t.rest.col(b)).norm();
  };
  return std::min(
      {length(corners[0], corners[1]), length(corners[1], corners[2]), length(corners[2], corners[0])});
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

/// Makes the first element with a vertex or an edge its owner.
class FeatureOwners {
 public:
  FeatureOwners(SurfaceTopology& t, std::size_t triangleEdges, bool rigid)
      : t_(t),
        triangleEdges_(triangleEdges),
        vertexOwned_(static_cast<std::size_t>(t.rest.cols())),
        edgeOwned_(t.edges.size()) {
    for (std::uint32_t e = 0; rigid && e < triangleEdges; ++e) edgeOwned_[e] = isUnreachable(t, e);
  }

  void addTriangle(std::uint32_t i) {
    SurfaceElement element;
    element.corners = t_.triangles[i];
    element.triangle = i;
    for (std::size_t k = 0; k < 3; ++k) {
      const Edge edge = sorted(element.corners[k], element.corners[(k + 1) % 3]);
      assignEdge(element, k, edgeIndex(t_.edges, triangleEdges_, edge));
      assignVertex(element, k, element.corners[k]);
    }
    t_.elements.push_back(element);
  }
  void addSegment(std::uint32_t edge) {
    SurfaceElement element;
    const auto [a, b] = t_.edges[edge];
    element.corners = {a, b, b};
    assignEdge(element, 0, edge);
    assignVertex(element, 0, a);
    assignVertex(element, 1, b);
    t_.elements.push_back(element);
  }
  void addVertex(std::uint32_t v) {
    if (vertexOwned_[v]) return;
    SurfaceElement element;
    element.corners = {v, v, v};
    assignVertex(element, 0, v);
    t_.elements.push_back(element);
  }

 private:
  void assignEdge(SurfaceElement& element, std::size_t slot, std::uint32_t edge) {
    if (!edgeOwned_[edge]) element.edges[slot] = edge;
    edgeOwned_[edge] = true;
  }
  void assignVertex(SurfaceElement& element, std::size_t slot, std::uint32_t v) {
    if (vertexOwned_[v]) return;
    element.vertices[slot] = v;
    t_.vertices.push_back(v);
    vertexOwned_[v] = true;
  }

  SurfaceTopology& t_;
  std::size_t triangleEdges_;
  std::vector<bool> vertexOwned_, edgeOwned_;
};

}  // namespace

Result<SurfaceTopology> makeSurfaceTopology(const Points& rest, const SurfaceFeatures& features) {
  const std::string reason = check(rest, features);
  if (!reason.empty()) return Error{reason};
  SurfaceTopology t;
  t.rest = rest;
  t.triangles = features.triangles;
  t.edges = allEdges(features);
  const std::size_t triangleEdges = uniqueEdges(features.triangles).size();
  setEdgeTriangles(t, triangleEdges);
  t.oneSided = findOneSided(t, triangleEdges, features.outward);
  for (const Triangle& corners : t.triangles) t.depthLimit.push_back(kDepthShare * shortestSide(t, corners));
  for (const Edge& e : t.edges)
    t.featureSize += (rest.col(e[0]) - rest.col(e[1])).norm() / double(t.edges.size());
  t.edgesAround = listsAround(rest.cols(), t.edges);
  t.trianglesAround = listsAround(rest.cols(), t.triangles);
  FeatureOwners owners(t, triangleEdges, features.rigid);
  for (std::uint32_t i = 0; i < t.triangles.size(); ++i) owners.addTriangle(i);
  for (std::size_t e = triangleEdges; e < t.edges.size(); ++e)
    owners.addSegment(static_cast<std::uint32_t>(e));
  for (const std::uint32_t v : features.vertices) owners.addVertex(v);
  t.nodes = makeSurfaceTree(rest, t.elements);
  return t;
}

}  // namespace limber
