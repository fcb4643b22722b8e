// SPDX-License-Identifier: Zlib
// Checks a triangle mesh and welds its vertices into points. Drops triangles without area and duplicate
// triangles, and reports the properties of the mesh.

#include <limber/mesh.h>

#include "mesh/surface.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>

namespace limber {
namespace {

/// m, or the unit of the file: volumes and their squares are far from the limits of a double.
constexpr double kMaxCoordinate = 1e9;

std::string checkCount(const char* name, std::size_t count, std::size_t vertices) {
  if (count == 0 || count == vertices) return {};
  return std::to_string(count) + " " + name + " for " + std::to_string(vertices) + " vertices";
}

std::string check(const TriangleMesh& mesh) {
  const std::size_t vertices = mesh.positions.size();
  if (vertices == 0) return "the mesh has no vertices";
  if (mesh.triangles.empty()) return "the mesh has no triangles";
  std::string reason = checkCount("normals", mesh.normals.size(), vertices);
  if (reason.empty()) reason = checkCount("texture coordinates", mesh.uvs.size(), vertices);
  if (!reason.empty()) return reason;
  for (std::size_t vertex = 0; vertex < vertices; ++vertex) {
    const Eigen::Vector3d& position = mesh.positions[vertex];
    if (!position.allFinite()) return "the position of vertex " + std::to_string(vertex) + " is not finite";
    if (position.cwiseAbs().maxCoeff() > kMaxCoordinate)
      return "the position of vertex " + std::to_string(vertex) + " has a coordinate beyond 1e9";
  }
  return checkCorners(mesh.triangles, vertices, "triangle", "vertex");
}

}  // namespace

Result<void> validate(const TriangleMesh& mesh) {
  std::string reason = check(mesh);
  return reason.empty() ? Result<void>() : Error{std::move(reason)};
}

namespace {

using Cell = std::array<std::int64_t, 3>;

/// Width of cells in tolerances. With 4, the search of a position visits 3 or 4 cells on average.
constexpr double kTolerancesPerCell = 4.0;

/// Smallest width of cells, relative to the largest coordinate. The numbers of narrower cells would exceed
/// the integers that a double represents.
constexpr double kMinCellWidth = 0x1p-40;

/// Search distance in tolerances: the excess is more than rounding can shift a border.
constexpr double kSearchMargin = 1.001;

/// The accepted positions, by their cell. A cell holds few of them, because their distances are larger than
/// the tolerance.
struct PositionGrid {
  double largest;  ///< no coordinate of any position is farther from 0
  double cellWidth;
  std::map<Cell, std::vector<std::uint32_t>> cells{};

  Cell cellOf(const Eigen::Vector3d& position) const {
    const Eigen::Vector3d inside = position.cwiseMax(-largest).cwiseMin(largest);
    const Eigen::Vector3d cell = (inside / cellWidth).array().floor();
    return {static_cast<std::int64_t>(cell.x()), static_cast<std::int64_t>(cell.y()),
            static_cast<std::int64_t>(cell.z())};
  }
};

struct Nearest {
  std::uint32_t index = kNoPoint;
  double distance = std::numeric_limits<double>::infinity();
};

/// Returns the nearest accepted position if one lies within the tolerance, of equally near ones the first;
/// farther ones may be missed.
Nearest findNearest(const PositionGrid& grid, const std::vector<Eigen::Vector3d>& positions,
                    const Eigen::Vector3d& position, double tolerance) {
  const Eigen::Vector3d searchDistance = Eigen::Vector3d::Constant(tolerance * kSearchMargin);
  const Cell low = grid.cellOf(position - searchDistance), high = grid.cellOf(position + searchDistance);
  Nearest nearest;
  for (std::int64_t x = low[0]; x <= high[0]; ++x)
    for (std::int64_t y = low[1]; y <= high[1]; ++y) {
      // cells along z follow each other in the map
      const auto end = grid.cells.upper_bound({x, y, high[2]});
      for (auto cell = grid.cells.lower_bound({x, y, low[2]}); cell != end; ++cell)
        for (const std::uint32_t other : cell->second) {
          const double distance = (positions[other] - position).stableNorm();
          const bool isEarlierTie = distance == nearest.distance && other < nearest.index;
          if (distance < nearest.distance || isEarlierTie) nearest = {other, distance};
        }
    }
  return nearest;
}

// mergeEqual() and mergeNearby() return for each position the index of the position that it joins, never a
// later one. A position that joins none keeps its own index. The result has #positions entries. Both need
// finite positions.

/// Returns for each value the index of the first one that is equal to it.
template <class T>
std::vector<std::uint32_t> firstOfEqual(const std::vector<T>& values) {
  std::vector<std::uint32_t> order(values.size()), first(values.size());
  std::iota(order.begin(), order.end(), 0u);
  std::sort(order.begin(), order.end(), [&](std::uint32_t i, std::uint32_t j) {
    return values[i] < values[j] || (i < j && !(values[j] < values[i]));
  });
  for (std::size_t i = 0; i < order.size(); ++i) {
    const bool isEqual = i > 0 && values[order[i - 1]] == values[order[i]];
    first[order[i]] = isEqual ? first[order[i - 1]] : order[i];
  }
  return first;
}

/// Joins equal positions (-0 equals 0) to the first of them.
std::vector<std::uint32_t> mergeEqual(const std::vector<Eigen::Vector3d>& positions) {
  std::vector<std::array<double, 3>> coordinates;
  coordinates.reserve(positions.size());
  for (const Eigen::Vector3d& p : positions) coordinates.push_back({p.x(), p.y(), p.z()});
  return firstOfEqual(coordinates);
}

/// Visits the positions in order. Each one joins the nearest accepted one within `tolerance` (the first of
/// equally near ones), or is accepted itself. The tolerance must be above 0.
std::vector<std::uint32_t> mergeNearby(const std::vector<Eigen::Vector3d>& positions, double tolerance) {
  double largest = 0.0;
  for (const Eigen::Vector3d& p : positions) largest = std::max(largest, p.cwiseAbs().maxCoeff());
  PositionGrid grid{largest, std::max(tolerance * kTolerancesPerCell, largest * kMinCellWidth)};
  std::vector<std::uint32_t> joined(positions.size());
  for (std::uint32_t i = 0; i < joined.size(); ++i) {
    const Nearest nearest = findNearest(grid, positions, positions[i], tolerance);
    const bool joins = nearest.distance <= tolerance;
    joined[i] = joins ? nearest.index : i;
    if (!joins) grid.cells[grid.cellOf(positions[i])].push_back(i);
  }
  return joined;
}

/// A triangle with a smaller height, relative to its longest side, has no area. Mesh files hold floats, whose
/// precision cannot distinguish its corners from points on a line.
constexpr double kMinHeight = 1e-7;

/// Returns for each used vertex the vertex whose position it gets; kNoPoint for the others.
std::vector<std::uint32_t> joinVertices(const TriangleMesh& mesh, double tolerance) {
  const std::vector<std::uint32_t> used = usedPoints(mesh.positions.size(), mesh.triangles);
  const std::vector<Eigen::Vector3d> positions = chosen(mesh.positions, used);
  const std::vector<std::uint32_t> joined =
      tolerance > 0.0 ? mergeNearby(positions, tolerance) : mergeEqual(positions);
  std::vector<std::uint32_t> joinedVertex(mesh.positions.size(), kNoPoint);
  for (std::size_t i = 0; i < used.size(); ++i) joinedVertex[used[i]] = used[joined[i]];
  return joinedVertex;
}

/// Twice the area is |e1 x e2|; the height over the longest side L is |e1 x e2| / L. The sides are divided by
/// their largest coordinate first, so that tiny and huge triangles neither underflow nor overflow.
bool hasArea(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
  const double size = std::max((b - a).cwiseAbs().maxCoeff(), (c - a).cwiseAbs().maxCoeff());
  const Eigen::Vector3d e1 = (b - a) / size, e2 = (c - a) / size;
  const double longest = std::sqrt(std::max({e1.squaredNorm(), e2.squaredNorm(), (e2 - e1).squaredNorm()}));
  return e1.cross(e2).norm() > kMinHeight * longest * longest;
}

bool isDegenerate(const Triangle& t, const std::vector<Eigen::Vector3d>& positions) {
  if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) return true;
  return !hasArea(positions[t[0]], positions[t[1]], positions[t[2]]);
}

/// Fills triangles (still with the indices of joined vertices), keptTriangles and the counts of the dropped
/// triangles.
void keepValidTriangles(const TriangleMesh& mesh, const std::vector<std::uint32_t>& joined,
                        WeldedMesh& welded) {
  std::vector<Triangle> triangles, sorted;
  for (const Triangle& t : mesh.triangles) {
    triangles.push_back({joined[t[0]], joined[t[1]], joined[t[2]]});
    sorted.push_back(triangles.back());
    std::sort(sorted.back().begin(), sorted.back().end());
  }
  const std::vector<std::uint32_t> first = firstOfEqual(sorted);
  for (std::uint32_t i = 0; i < triangles.size(); ++i) {
    if (isDegenerate(triangles[i], mesh.positions)) {
      ++welded.report.degenerateTriangles;
    } else if (first[i] != i) {
      ++welded.report.duplicateTriangles;
    } else {
      welded.triangles.push_back(triangles[i]);
      welded.keptTriangles.push_back(i);
    }
  }
}

/// Numbers the points in the order of the first vertex that uses them, and sets their numbers in the
/// triangles.
void numberPoints(const TriangleMesh& mesh, const std::vector<std::uint32_t>& joined, WeldedMesh& welded) {
  const std::size_t vertices = mesh.positions.size();
  Renumbering numbers(vertices);  // of the joined vertices
  welded.vertexToPoint.assign(vertices, kNoPoint);
  for (const std::uint32_t vertex : usedPoints(vertices, chosen(mesh.triangles, welded.keptTriangles)))
    welded.vertexToPoint[vertex] = numbers(joined[vertex]);
  welded.points = chosen(mesh.positions, numbers.kept());
  for (Triangle& t : welded.triangles) t = numbers(t);
}

void completeReport(WeldedMesh& welded) {
  MeshReport& report = welded.report;
  const std::vector<std::uint32_t>& map = welded.vertexToPoint;
  report.vertices = map.size();
  report.points = welded.points.size();
  report.triangles = welded.triangles.size();
  report.isolatedVertices = static_cast<std::size_t>(std::count(map.begin(), map.end(), kNoPoint));
  report.components = findComponents(welded.points.size(), welded.triangles).count;
  setEdgeDefects(report, welded.triangles);
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
  if (Result<void> valid = validate(mesh); !valid) return Error{valid.error()};
  if (!std::isfinite(tolerance) || tolerance < 0.0) {
    return Error{"the weld tolerance is " + std::to_string(tolerance) + ", it must be a length of 0 or more"};
  }
  WeldedMesh welded;
  const std::vector<std::uint32_t> joined = joinVertices(mesh, tolerance);
  keepValidTriangles(mesh, joined, welded);
  if (welded.triangles.empty()) {
    return Error{"none of the " + std::to_string(mesh.triangles.size()) + " triangles has an area"};
  }
  numberPoints(mesh, joined, welded);
  completeReport(welded);
  return welded;
}

}  // namespace limber
