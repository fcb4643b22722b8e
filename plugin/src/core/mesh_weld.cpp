// SPDX-License-Identifier: Zlib
#include <limber/mesh_weld.h>

#include "core/counted.h"
#include "core/merge_positions.h"
#include "core/mesh_edges.h"
#include "core/surface_components.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace limber {
namespace {

/// A triangle whose height is below this part of its longest side has no area: mesh files hold floats, and
/// these cannot tell such corners from points of one line.
constexpr double kFlattestTriangle = 1e-7;

/// Vertices that some triangle uses, in ascending order.
std::vector<std::uint32_t> usedVertices(std::size_t vertices, const std::vector<Triangle>& triangles) {
  std::vector<char> isUsed(vertices, 0);
  for (const Triangle& t : triangles) {
    for (const std::uint32_t vertex : t) isUsed[vertex] = 1;
  }
  std::vector<std::uint32_t> used;
  for (std::uint32_t vertex = 0; vertex < vertices; ++vertex) {
    if (isUsed[vertex]) used.push_back(vertex);
  }
  return used;
}

/// For each vertex in use the vertex whose position it takes; kNoPoint for the others.
std::vector<std::uint32_t> joinVertices(const TriangleMesh& mesh, double tolerance) {
  const std::vector<std::uint32_t> used = usedVertices(mesh.positions.size(), mesh.triangles);
  std::vector<Eigen::Vector3d> positions;
  positions.reserve(used.size());
  for (const std::uint32_t vertex : used) positions.push_back(mesh.positions[vertex]);

  const std::vector<std::uint32_t> joined =
      tolerance > 0.0 ? mergeNearby(positions, tolerance) : mergeEqual(positions);
  std::vector<std::uint32_t> joinedVertex(mesh.positions.size(), kNoPoint);
  for (std::size_t i = 0; i < used.size(); ++i) joinedVertex[used[i]] = used[joined[i]];
  return joinedVertex;
}

/// Twice the area is |e1 x e2|, the height over the longest side L is |e1 x e2| / L. Divided by the largest
/// coordinate first, so that tiny and huge triangles neither underflow nor overflow.
bool hasArea(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
  const double size = std::max((b - a).cwiseAbs().maxCoeff(), (c - a).cwiseAbs().maxCoeff());
  const Eigen::Vector3d e1 = (b - a) / size, e2 = (c - a) / size;
  const double longest = std::sqrt(std::max({e1.squaredNorm(), e2.squaredNorm(), (e2 - e1).squaredNorm()}));
  return e1.cross(e2).norm() > kFlattestTriangle * longest * longest;
}

bool isDegenerate(const Triangle& t, const std::vector<Eigen::Vector3d>& positions) {
  if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) return true;
  return !hasArea(positions[t[0]], positions[t[1]], positions[t[2]]);
}

/// Which triangles have the same three corners as an earlier one, whatever their order.
std::vector<char> findDuplicates(const std::vector<Triangle>& triangles) {
  std::vector<std::pair<Triangle, std::size_t>> sorted;
  sorted.reserve(triangles.size());
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    Triangle corners = triangles[i];
    std::sort(corners.begin(), corners.end());
    sorted.emplace_back(corners, i);
  }
  std::sort(sorted.begin(), sorted.end());

  std::vector<char> isDuplicate(triangles.size(), 0);
  for (std::size_t k = 1; k < sorted.size(); ++k) {
    if (sorted[k].first == sorted[k - 1].first) isDuplicate[sorted[k].second] = 1;
  }
  return isDuplicate;
}

/// Fills triangles (still with the indices of joined vertices), keptTriangles and the counts of those
/// dropped.
void keepSoundTriangles(const TriangleMesh& mesh, const std::vector<std::uint32_t>& joined,
                        WeldedMesh& welded) {
  std::vector<Triangle> triangles;
  triangles.reserve(mesh.triangles.size());
  for (const Triangle& t : mesh.triangles) triangles.push_back({joined[t[0]], joined[t[1]], joined[t[2]]});

  const std::vector<char> isDuplicate = findDuplicates(triangles);
  for (std::uint32_t i = 0; i < triangles.size(); ++i) {
    if (isDegenerate(triangles[i], mesh.positions)) {
      ++welded.report.degenerateTriangles;
    } else if (isDuplicate[i]) {
      ++welded.report.duplicateTriangles;
    } else {
      welded.triangles.push_back(triangles[i]);
      welded.keptTriangles.push_back(i);
    }
  }
}

/// Numbers the points in the order of the first vertex that uses them, and puts their numbers into the
/// triangles.
void numberPoints(const TriangleMesh& mesh, const std::vector<std::uint32_t>& joined, WeldedMesh& welded) {
  std::vector<Triangle> kept;
  for (const std::uint32_t i : welded.keptTriangles) kept.push_back(mesh.triangles[i]);

  std::vector<std::uint32_t> pointOf(mesh.positions.size(), kNoPoint);  // by joined vertex
  welded.vertexToPoint.assign(mesh.positions.size(), kNoPoint);
  for (const std::uint32_t vertex : usedVertices(mesh.positions.size(), kept)) {
    std::uint32_t& point = pointOf[joined[vertex]];
    if (point == kNoPoint) {
      point = static_cast<std::uint32_t>(welded.points.size());
      welded.points.push_back(mesh.positions[joined[vertex]]);
    }
    welded.vertexToPoint[vertex] = point;
  }
  for (Triangle& t : welded.triangles) t = {pointOf[t[0]], pointOf[t[1]], pointOf[t[2]]};
}

void completeReport(WeldedMesh& welded) {
  MeshReport& report = welded.report;
  const std::vector<std::uint32_t>& map = welded.vertexToPoint;
  const EdgeDefects defects = findEdgeDefects(welded.triangles);
  report.vertices = map.size();
  report.points = welded.points.size();
  report.triangles = welded.triangles.size();
  report.isolatedVertices = static_cast<std::size_t>(std::count(map.begin(), map.end(), kNoPoint));
  report.components = findComponents(welded.points.size(), welded.triangles).count;
  report.openEdges = defects.open;
  report.nonManifoldEdges = defects.nonManifold;
  report.inconsistentEdges = defects.inconsistent;
}

}  // namespace

std::string describe(const MeshReport& report) {
  std::string text = counted(report.vertices, "vertex", "vertices") + " -> " +
                     counted(report.points, "point", "points") + ", " +
                     counted(report.triangles, "triangle", "triangles") + ", " +
                     counted(report.components, "component", "components");
  const auto add = [&](std::size_t count, const char* one, const char* many) {
    if (count > 0) text += ", " + counted(count, one, many);
  };
  add(report.degenerateTriangles, "degenerate triangle", "degenerate triangles");
  add(report.duplicateTriangles, "duplicate triangle", "duplicate triangles");
  add(report.isolatedVertices, "isolated vertex", "isolated vertices");
  add(report.openEdges, "open edge", "open edges");
  add(report.nonManifoldEdges, "non-manifold edge", "non-manifold edges");
  add(report.inconsistentEdges, "inconsistent edge", "inconsistent edges");
  if (report.watertight()) text += ", watertight";
  return text;
}

Result<WeldedMesh> weld(const TriangleMesh& mesh, double tolerance) {
  if (std::string reason = validate(mesh); !reason.empty()) return Error{std::move(reason)};
  if (!std::isfinite(tolerance) || tolerance < 0.0) {
    return Error{"the weld tolerance is " + std::to_string(tolerance) + ", it must be a length of 0 or more"};
  }
  WeldedMesh welded;
  const std::vector<std::uint32_t> joined = joinVertices(mesh, tolerance);
  keepSoundTriangles(mesh, joined, welded);
  if (welded.triangles.empty()) {
    return Error{"none of the " + std::to_string(mesh.triangles.size()) + " triangles has an area"};
  }
  numberPoints(mesh, joined, welded);
  completeReport(welded);
  return welded;
}

}  // namespace limber
