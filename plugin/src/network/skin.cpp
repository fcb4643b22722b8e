// SPDX-License-Identifier: Zlib
// Makes a detailed mesh follow the points of a network. Finds the points that are near only across a gap in
// the body first, and gives them little weight.

#include "network/skin.h"
#include "network/tetrahedra.h"

namespace limber {
namespace {

using Eigen::Index;
using Eigen::Vector3d;

/// Number of nearest points to which straight paths are tested; farther ones have little weight in a skin.
constexpr std::size_t kMaxNeighbours = 200;
/// Fraction of the size of the body by which straight paths may leave the surface.
constexpr double kGapTolerance = 1e-3;
/// Paths longer than this times the distance of the farthest of the nearest points are cut off.
constexpr double kMaxPathRatio = 3.0;
/// kFreeDetour: the variance begins where the square of the path is this many times that of the straight
/// line. (Paths bend only at points, so they are somewhat too long.) kVariance: factor by which the variance
/// grows faster than the kernel.
constexpr double kFreeDetour = 1.5, kVariance = 30.0;
/// Largest number of rounds of averaging over the detailed mesh, and the size of entries that are dropped
/// between them.
constexpr std::size_t kMaxGapRounds = 200;
constexpr double kNegligible = 1e-3;

/// Returns the nearest points, the nearest first, without `point`.
std::vector<Link> nearestPoints(const std::vector<Vector3d>& points, std::uint32_t point) {
  std::vector<Link> all;
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    if (i != point) all.push_back({i, (points[i] - points[point]).norm()});
  }
  const std::size_t count = std::min(kMaxNeighbours, all.size());
  std::partial_sort(
      all.begin(), all.begin() + static_cast<std::ptrdiff_t>(count), all.end(),
      [](const Link& s, const Link& t) { return s.length != t.length ? s.length < t.length : s.to < t.to; });
  all.resize(count);
  return all;
}

/// Returns the edges of triangles and tetrahedra.
Links elementLinks(const SpringNetwork& network) {
  std::vector<Edge> edges = uniqueEdges(network.surface);
  const std::vector<Edge> inside = uniqueEdges(network.tetrahedra);
  edges.insert(edges.end(), inside.begin(), inside.end());
  sortUnique(edges);
  return edgeLinks(network.restPoints, edges);
}

/// Adds the straight links that stay inside. Returns for each point whether a straight path to a near point
/// leaves the surface.
std::vector<char> addStraightLinks(Links& links, const std::vector<Vector3d>& points,
                                   const std::vector<std::vector<Link>>& nearest,
                                   const TriangleBvh& surface) {
  const double tolerance = kGapTolerance * extent(points);
  std::vector<char> hidden(points.size(), 0);
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    for (const Link& link : nearest[i]) {
      const bool isMutual = std::any_of(nearest[link.to].begin(), nearest[link.to].end(),
                                        [&](const Link& back) { return back.to == i; });
      if (isMutual && link.to < i) continue;
      if (surface.staysInside(points[i], points[link.to], tolerance)) {
        connect(links, points, i, link.to);
      } else {
        hidden[i] = hidden[link.to] = 1;
      }
    }
  }
  return hidden;
}

double variance(double path, double straight) {
  const double excess = path * path - kFreeDetour * straight * straight;
  return excess > 0.0 ? kVariance * std::pow(excess, 1.5) : 0.0;
}

/// Returns a matrix that averages: each row is the mean of a vertex and its neighbours.
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

/// Returns the uncertainty of a point's motion as a prediction of the motion of another point that is near it
/// only across a gap, #points x #points, m^3. It is a variance comparable to that of |r|^3 interpolation,
/// where the expected square of the difference between two positions grows with the cube of their distance.
/// It grows from 0 as the shortest path through the body becomes longer than the straight line. Entries of 0,
/// and of points that are not among each other's nearest, are not stored.
SparseRows gapVariances(const SpringNetwork& network, const TriangleBvh& surface) {
  const std::vector<Vector3d>& points = network.restPoints;
  std::vector<std::vector<Link>> nearest;
  for (std::uint32_t i = 0; i < points.size(); ++i) nearest.push_back(nearestPoints(points, i));
  Links links = elementLinks(network);
  const std::vector<char> hidden = addStraightLinks(links, points, nearest, surface);

  std::vector<Eigen::Triplet<double>> entries;
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    if (!hidden[i]) continue;
    const std::vector<double> length = shortestPaths(links, i, kMaxPathRatio * nearest[i].back().length);
    for (const Link& link : nearest[i]) {
      const double v = variance(length[link.to], link.length);
      if (v > 0.0) entries.emplace_back(i, link.to, v);
    }
  }
  SparseRows result(static_cast<Index>(points.size()), static_cast<Index>(points.size()));
  result.setFromTriplets(entries.begin(), entries.end());
  return result;
}

/// Returns how much the vertices of a detailed mesh belong to the points of the coarse surface, from 0 to 1,
/// #vertices x #points. The result is smooth over the detailed mesh, so that it ignores parts that are only
/// near.
///
/// The function begins with the barycentric coordinates of the nearest place on the coarse surface that faces
/// the same direction. It blurs them over about half a coarse edge, so that there are no kinks at the edges
/// of the coarse surface.
SparseRows membership(const WeldedMesh& mesh, const SpringNetwork& network, const TriangleBvh& surface) {
  std::vector<Eigen::Triplet<double>> entries;
  const std::vector<Vector3d> normals = vertexNormals(mesh.points, mesh.triangles);
  for (std::size_t i = 0; i < mesh.points.size(); ++i) {
    const TriangleHit foot = surface.nearestWithin(mesh.points[i], HUGE_VAL, normals[i]);
    if (!foot) continue;
    for (int c = 0; c < 3; ++c) {
      const std::uint32_t point = network.surface[foot.triangle][static_cast<std::size_t>(c)];
      // rounding may make it negative, which has no root
      entries.emplace_back(static_cast<Index>(i), static_cast<Index>(point),
                           std::max(0.0, foot.barycentric[c]));
    }
  }
  SparseRows result(static_cast<Index>(mesh.points.size()), static_cast<Index>(network.restPoints.size()));
  result.setFromTriplets(entries.begin(), entries.end());
  const SparseRows average = averaging(mesh);
  const std::size_t rounds = mesh.points.size() / (2 * network.restPoints.size());
  for (std::size_t round = 0; round < std::min(rounds, kMaxGapRounds); ++round) {
    result = SparseRows(average * result);
    result.prune(1.0, kNegligible);
  }
  return result;
}

/// Each takes 8 bytes in the skin and 12 more during its construction.
constexpr std::size_t kMaxWeights = 20'000'000;

SkinProblem makeProblem(const SpringNetwork& network, const WeldedMesh& mesh, SkinKind kind) {
  SkinProblem problem{network.restPoints, mesh.points, vertexNormals(mesh.points, mesh.triangles), {}};
  if (kind == SkinKind::Barycentric) return problem;
  const TriangleBvh surface(network.restPoints, network.surface);
  problem.variances = membership(mesh, network, surface) * gapVariances(network, surface);
  return problem;
}

std::string checkInput(const SpringNetwork& network, const WeldedMesh& mesh, const SkinSettings& settings) {
  if (settings.neighbours < 4)
    return "a skin of " + std::to_string(settings.neighbours) +
           " neighbours per vertex is not possible, it needs 4 or more";
  if (Result<void> valid = validate(network); !valid) return "network: " + valid.error();
  if (network.surface.empty()) return "a network without a surface has no skin";
  if (!spansSpace(network.restPoints))
    return "the points of the network lie in a plane, so they cannot move a skin";
  const std::size_t weights =
      std::max(mesh.points.size(), network.restPoints.size()) * network.restPoints.size();
  if (settings.kind == SkinKind::Dense && weights > kMaxWeights) {
    return "a dense skin of " + std::to_string(mesh.points.size()) + " vertices on " +
           std::to_string(network.restPoints.size()) + " points takes " + std::to_string(weights) +
           " numbers, more than " + std::to_string(kMaxWeights) + ": use a sparse one";
  }
  return {};
}

SkinWeights solve(const SpringNetwork& network, const SkinProblem& problem, const SkinSettings& settings) {
  if (settings.kind == SkinKind::Dense) return denseWeights(problem);
  if (settings.kind == SkinKind::Sparse) return sparseWeights(problem, settings.neighbours);
  return network.tetrahedra.empty() ? triangleWeights(problem, network.surface)
                                    : tetrahedronWeights(problem, network.tetrahedra);
}

/// Rounds the largest weight first. Each one also corrects the rounding errors of those before, so the
/// remaining error is that of the smallest.
void roundPlace(const SkinWeights& exact, std::uint32_t begin, std::uint32_t end,
                std::vector<float>& weights) {
  std::vector<std::uint32_t> order(end - begin);
  std::iota(order.begin(), order.end(), begin);
  std::stable_sort(order.begin(), order.end(), [&](std::uint32_t i, std::uint32_t j) {
    return std::abs(exact.weights[i]) > std::abs(exact.weights[j]);
  });
  double error = 0.0;
  for (const std::uint32_t w : order) {
    weights[w] = static_cast<float>(exact.weights[w] + error);
    error += exact.weights[w] - static_cast<double>(weights[w]);
  }
}

}  // namespace

RenderSurface makeRenderSurface(const TriangleMesh& mesh, const WeldedMesh& welded, Skin skin) {
  RenderSurface render;
  render.skin = std::move(skin);
  render.vertexToPoint = welded.vertexToPoint;
  render.uvs = mesh.uvs;
  render.triangles.reserve(welded.keptTriangles.size());
  for (const std::uint32_t kept : welded.keptTriangles) render.triangles.push_back(mesh.triangles[kept]);
  return render;
}

Skin rounded(const SkinWeights& exact) {
  Skin skin{exact.firstWeight, exact.points, std::vector<float>(exact.weights.size())};
  for (std::size_t i = 0; i < skin.size(); ++i)
    roundPlace(exact, exact.firstWeight[i], exact.firstWeight[i + 1], skin.weights);
  return skin;
}

Result<SkinWeights> skinWeights(const SpringNetwork& network, const WeldedMesh& mesh,
                                const SkinSettings& settings) {
  if (std::string reason = checkInput(network, mesh, settings); !reason.empty())
    return Error{std::move(reason)};
  SkinWeights weights = solve(network, makeProblem(network, mesh, settings.kind), settings);
  const auto finite = [](double w) { return std::isfinite(w); };
  if (!std::all_of(weights.weights.begin(), weights.weights.end(), finite))
    return Error{
        "the skin has weights that are not finite: points of the network coincide, or triangles have no "
        "area"};
  return weights;
}

Result<SharedNetwork> withSkin(const SpringNetwork& network, const TriangleMesh& mesh,
                               const SkinSettings& settings) {
  Result<WeldedMesh> welded = weld(mesh, settings.weldTolerance);
  if (!welded) return Error{welded.error()};
  const std::vector<bool> inward = welded->report.watertight()
                                       ? facingInward(welded->points, welded->triangles)
                                       : patchesFacingInward(welded->points, welded->triangles);
  flip(welded->triangles, inward);
  Result<SkinWeights> weights = skinWeights(network, *welded, settings);
  if (!weights) return Error{weights.error()};
  auto skinned = std::make_shared<SpringNetwork>(network);
  skinned->render = makeRenderSurface(mesh, *welded, rounded(*weights));
  flip(skinned->render.triangles, inward);
  if (Result<void> valid = validate(*skinned); !valid) return Error{"the skin: " + valid.error()};
  return SharedNetwork(std::move(skinned));
}

/// Sums relative to the first point of each place, so that no precision is lost far from the origin.
void applySkin(const Skin& skin, const float* points, float* places) {
  for (std::size_t i = 0; i < skin.size(); ++i) {
    const std::uint32_t begin = skin.firstWeight[i], end = skin.firstWeight[i + 1];
    const float* origin = points + 3 * std::size_t(skin.points[begin]);
    float x = 0.0f, y = 0.0f, z = 0.0f;
    for (std::uint32_t w = begin; w < end; ++w) {
      const float* p = points + 3 * std::size_t(skin.points[w]);
      x += skin.weights[w] * (p[0] - origin[0]);
      y += skin.weights[w] * (p[1] - origin[1]);
      z += skin.weights[w] * (p[2] - origin[2]);
    }
    places[3 * i] = origin[0] + x;
    places[3 * i + 1] = origin[1] + y;
    places[3 * i + 2] = origin[2] + z;
  }
}

}  // namespace limber
