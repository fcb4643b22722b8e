// SPDX-License-Identifier: Zlib
#include "cook/skin_gaps.h"

#include "mesh/edges.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <queue>
#include <utility>

namespace limber {
namespace {

using Eigen::Index;
using Eigen::Vector3d;

/// Points whose straight ways are looked at; those farther off hardly weigh in a skin.
constexpr std::size_t kNearest = 200;
/// How far straight ways may leave the surface, of the size of the body.
constexpr double kGapTolerance = 1e-3;
/// Ways longer than this times the distance of the farthest of the nearest are cut.
constexpr double kLongestWay = 3.0;
/// The variance begins where the square of the way is this many times that of the straight line (ways bend at
/// points only, so that they are somewhat too long), and grows this much faster than the kernel.
constexpr double kFreeDetour = 1.5, kVariance = 30.0;
/// Rounds of averaging over the detailed mesh at most, and what is dropped between them.
constexpr std::size_t kMostGapRounds = 200;
constexpr double kNegligible = 1e-3;

struct Way {
  std::uint32_t to;
  double length;
};

using Ways = std::vector<std::vector<Way>>;

/// Nearest first, without `point`.
std::vector<Way> nearestPoints(const std::vector<Vector3d>& points, std::uint32_t point) {
  std::vector<Way> all;
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    if (i != point) all.push_back({i, (points[i] - points[point]).norm()});
  }
  const std::size_t count = std::min(kNearest, all.size());
  std::partial_sort(
      all.begin(), all.begin() + static_cast<std::ptrdiff_t>(count), all.end(),
      [](const Way& s, const Way& t) { return s.length != t.length ? s.length < t.length : s.to < t.to; });
  all.resize(count);
  return all;
}

void connect(Ways& ways, const std::vector<Vector3d>& points, std::uint32_t a, std::uint32_t b) {
  const double length = (points[a] - points[b]).norm();
  ways[a].push_back({b, length});
  ways[b].push_back({a, length});
}

/// Edges of triangles and tetrahedra.
Ways edgeWays(const SpringNetwork& network) {
  Ways ways(network.restPoints.size());
  for (const Edge& edge : uniqueEdges(network.surface)) connect(ways, network.restPoints, edge[0], edge[1]);
  for (const Tetrahedron& t : network.tetrahedra) {
    for (std::size_t i = 0; i < 4; ++i) {
      for (std::size_t j = i + 1; j < 4; ++j) connect(ways, network.restPoints, t[i], t[j]);
    }
  }
  return ways;
}

/// Adds the straight ways that stay inside; which points have a near one that they do not see.
std::vector<char> addStraightWays(Ways& ways, const std::vector<Vector3d>& points,
                                  const std::vector<std::vector<Way>>& nearest, const TriangleBvh& surface) {
  const double tolerance = kGapTolerance * extent(points);
  std::vector<char> hidden(points.size(), 0);
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    for (const Way& way : nearest[i]) {
      const bool otherLooksToo = std::any_of(nearest[way.to].begin(), nearest[way.to].end(),
                                             [&](const Way& back) { return back.to == i; });
      if (otherLooksToo && way.to < i) continue;
      if (surface.staysInside(points[i], points[way.to], tolerance)) {
        connect(ways, points, i, way.to);
      } else {
        hidden[i] = hidden[way.to] = 1;
      }
    }
  }
  return hidden;
}

/// Lengths of the shortest ways from `from` (E. Dijkstra, 1959), `longest` where there is no shorter one.
void shortestWays(const Ways& ways, std::uint32_t from, double longest, std::vector<double>& length) {
  using Arrival = std::pair<double, std::uint32_t>;
  std::priority_queue<Arrival, std::vector<Arrival>, std::greater<>> front;
  std::fill(length.begin(), length.end(), longest);
  length[from] = 0.0;
  front.push({0.0, from});
  while (!front.empty()) {
    const auto [here, point] = front.top();
    front.pop();
    if (here > length[point]) continue;
    for (const Way& way : ways[point]) {
      if (here + way.length >= length[way.to]) continue;
      length[way.to] = here + way.length;
      front.push({length[way.to], way.to});
    }
  }
}

double variance(double way, double straight) {
  const double excess = way * way - kFreeDetour * straight * straight;
  return excess > 0.0 ? kVariance * std::pow(excess, 1.5) : 0.0;
}

/// Each row the mean of a vertex and its neighbours.
SparseRows averaging(const WeldedMesh& mesh) {
  std::vector<Eigen::Triplet<double>> entries;
  const auto count = static_cast<Index>(mesh.points.size());
  for (Index i = 0; i < count; ++i) entries.emplace_back(i, i, 1.0);
  for (const Edge& e : uniqueEdges(mesh.triangles)) {
    entries.emplace_back(e[0], e[1], 1.0);
    entries.emplace_back(e[1], e[0], 1.0);
  }
  SparseRows matrix(count, count);
  matrix.setFromTriplets(entries.begin(), entries.end());
  const Eigen::VectorXd sums = matrix * Eigen::VectorXd::Ones(count);
  return sums.cwiseInverse().asDiagonal() * matrix;
}

}  // namespace

SparseRows gapVariances(const SpringNetwork& network, const TriangleBvh& surface) {
  const std::vector<Vector3d>& points = network.restPoints;
  std::vector<std::vector<Way>> nearest;
  for (std::uint32_t i = 0; i < points.size(); ++i) nearest.push_back(nearestPoints(points, i));
  Ways ways = edgeWays(network);
  const std::vector<char> hidden = addStraightWays(ways, points, nearest, surface);

  std::vector<Eigen::Triplet<double>> entries;
  std::vector<double> length(points.size());
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    if (!hidden[i]) continue;
    shortestWays(ways, i, kLongestWay * nearest[i].back().length, length);
    for (const Way& way : nearest[i]) {
      const double v = variance(length[way.to], way.length);
      if (v > 0.0) entries.emplace_back(i, way.to, v);
    }
  }
  SparseRows result(static_cast<Index>(points.size()), static_cast<Index>(points.size()));
  result.setFromTriplets(entries.begin(), entries.end());
  return result;
}

/// Begins with the barycentric coordinates of the nearest place on the coarse surface that faces the same
/// way, and blurs them over about half a coarse edge: no kinks at the edges of the coarse surface.
SparseRows belonging(const WeldedMesh& mesh, const SpringNetwork& network, const TriangleBvh& surface) {
  std::vector<Eigen::Triplet<double>> entries;
  const std::vector<Vector3d> normals = vertexNormals(mesh.points, mesh.triangles);
  for (std::size_t i = 0; i < mesh.points.size(); ++i) {
    const SurfaceHit foot = surface.nearestFacing(mesh.points[i], normals[i]);
    if (!foot) continue;
    for (int c = 0; c < 3; ++c) {
      const std::uint32_t point = network.surface[foot.triangle][static_cast<std::size_t>(c)];
      entries.emplace_back(static_cast<Index>(i), static_cast<Index>(point), foot.barycentric[c]);
    }
  }
  SparseRows result(static_cast<Index>(mesh.points.size()), static_cast<Index>(network.restPoints.size()));
  result.setFromTriplets(entries.begin(), entries.end());
  const SparseRows average = averaging(mesh);
  const std::size_t rounds = mesh.points.size() / (2 * network.restPoints.size());
  for (std::size_t round = 0; round < std::min(rounds, kMostGapRounds); ++round) {
    result = SparseRows(average * result);
    result.prune(1.0, kNegligible);
  }
  return result;
}

}  // namespace limber
