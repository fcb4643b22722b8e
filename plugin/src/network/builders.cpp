// SPDX-License-Identifier: Zlib
// Builds the networks of ropes, cloths and meshes.

#include <limber/network_builder.h>

#include "mesh/surface.h"
#include "network/bracing.h"
#include "network/masses.h"
#include "network/skin.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numeric>

namespace limber {
namespace {

/// A larger rope or cloth takes gigabytes and is probably a mistake.
constexpr double kMaxNetworkPoints = 1e7;

constexpr double kLargestSize = 1e9;  // m, as of the coordinates of any network

std::string checkSize(const char* name, double value) {
  if (value > kLargestSize) return mustBe(name, value, "at most 1e9");
  return std::isfinite(value) && value > 0.0 ? std::string() : mustBe(name, value, "above 0");
}

std::string checkZeroOrMore(const char* name, double value) {
  return std::isfinite(value) && value >= 0.0 ? std::string() : mustBe(name, value, "0 or more");
}

std::string checkOneOrMore(const char* name, std::uint32_t count) {
  return count > 0 ? std::string() : mustBe(name, 0.0, "1 or more");
}

std::string checkPoints(const char* name, double count) {
  return count <= kMaxNetworkPoints ? std::string() : mustBe(name, count, "at most ten million");
}

/// Returns the first reason that is not empty.
std::string firstOf(const std::vector<std::string>& reasons) {
  const auto first =
      std::find_if(reasons.begin(), reasons.end(), [](const std::string& r) { return !r.empty(); });
  return first != reasons.end() ? *first : std::string();
}

std::string check(const RopeSettings& s) {
  return firstOf({checkSize("length", s.length), checkOneOrMore("segments", s.segments),
                  checkPoints("segments", s.segments), checkZeroOrMore("bendingScale", s.bendingScale),
                  checkZeroOrMore("thickness", s.thickness)});
}

/// Joins each point, in order, to the points after it, so that the springs are sorted.
///
///     o---o---o---o   structural
///     o-------o       bending: skips one point
std::vector<NetworkSpring> ropeSprings(std::uint32_t segments, double bendingScale) {
  std::vector<NetworkSpring> springs;
  for (std::uint32_t i = 0; i < segments; ++i) {
    springs.push_back({i, i + 1, SpringKind::Structural, 1.0});
    if (bendingScale > 0.0 && i + 1 < segments)
      springs.push_back({i, i + 2, SpringKind::Bending, bendingScale});
  }
  return springs;
}

}  // namespace

Result<SharedNetwork> buildRope(const RopeSettings& settings) {
  if (std::string reason = check(settings); !reason.empty()) return Error{std::move(reason)};
  auto network = std::make_shared<SpringNetwork>();
  network->kind = NetworkKind::Rope;
  for (std::uint32_t i = 0; i <= settings.segments; ++i)
    network->restPoints.emplace_back(settings.length * i / settings.segments, 0.0, 0.0);
  network->massFractions.assign(settings.segments + 1, 1.0 / settings.segments);
  network->massFractions.front() = network->massFractions.back() = 0.5 / settings.segments;
  network->springs = ropeSprings(settings.segments, settings.bendingScale);
  network->thickness = settings.thickness;
  return SharedNetwork(std::move(network));
}

namespace {

/// Numbers of cells along x and z, and the index of the point in column i, row j.
struct Grid {
  std::uint32_t columns;
  std::uint32_t rows;

  std::uint32_t points() const { return (columns + 1) * (rows + 1); }
  std::uint32_t at(std::uint32_t i, std::uint32_t j) const { return j * (columns + 1) + i; }
};

std::string check(const ClothSettings& s) {
  return firstOf(
      {checkSize("width", s.width), checkSize("depth", s.depth), checkOneOrMore("columns", s.columns),
       checkOneOrMore("rows", s.rows),
       checkPoints("the number of points, (columns + 1) (rows + 1),", (s.columns + 1.0) * (s.rows + 1.0)),
       checkZeroOrMore("shearScale", s.shearScale), checkZeroOrMore("bendingScale", s.bendingScale),
       checkZeroOrMore("thickness", s.thickness),
       s.masses > MassRule::Moments ? "masses is no value of MassRule" : ""});
}

/// Adds the springs from point (i, j) to points after it, in ascending order of their index:
///
///     (i, j)    (i+1, j)  (i+2, j)       structural, bending
///     (i-1, j+1)  (i, j+1)  (i+1, j+1)   shear, structural, shear
///               (i, j+2)                 bending
///
/// Those along the border stand for a strip of half a cell.
void addSpringsOfPoint(const Grid& grid, const ClothSettings& settings, std::uint32_t i, std::uint32_t j,
                       std::vector<NetworkSpring>& springs) {
  const auto join = [&](std::uint32_t column, std::uint32_t row, SpringKind kind, double scale) {
    if (column > grid.columns || row > grid.rows || scale == 0.0) return;
    springs.push_back({grid.at(i, j), grid.at(column, row), kind, scale});
  };
  const double strip = j == 0 || j == grid.rows ? 0.5 : 1.0, column = i == 0 || i == grid.columns ? 0.5 : 1.0;
  join(i + 1, j, SpringKind::Structural, strip);
  join(i + 2, j, SpringKind::Bending, strip * settings.bendingScale);
  if (i > 0) join(i - 1, j + 1, SpringKind::Shear, settings.shearScale);
  join(i, j + 1, SpringKind::Structural, column);
  join(i + 1, j + 1, SpringKind::Shear, settings.shearScale);
  join(i, j + 2, SpringKind::Bending, column * settings.bendingScale);
}

std::vector<NetworkSpring> clothSprings(const Grid& grid, const ClothSettings& settings) {
  std::vector<NetworkSpring> springs;
  for (std::uint32_t j = 0; j <= grid.rows; ++j) {
    for (std::uint32_t i = 0; i <= grid.columns; ++i) addSpringsOfPoint(grid, settings, i, j, springs);
  }
  return springs;
}

/// The diagonals alternate as on a chess board. With parallel diagonals folds would prefer one direction.
std::vector<Triangle> clothTriangles(const Grid& grid) {
  std::vector<Triangle> triangles;
  for (std::uint32_t j = 0; j < grid.rows; ++j) {
    for (std::uint32_t i = 0; i < grid.columns; ++i) {
      const std::uint32_t a = grid.at(i, j), b = grid.at(i + 1, j), c = grid.at(i + 1, j + 1),
                          d = grid.at(i, j + 1);
      const bool alongAC = (i + j) % 2 == 0;
      triangles.push_back(alongAC ? Triangle{a, d, c} : Triangle{a, d, b});
      triangles.push_back(alongAC ? Triangle{a, c, b} : Triangle{b, d, c});
    }
  }
  return triangles;
}

/// Returns equal fractions, or for each point the share of a quarter of its cells.
std::vector<double> clothMasses(const Grid& grid, MassRule rule) {
  if (rule == MassRule::Equal) return std::vector<double>(grid.points(), 1.0 / grid.points());
  const auto share = [](std::uint32_t i, std::uint32_t cells) {
    return (i == 0 || i == cells ? 0.5 : 1.0) / cells;
  };
  std::vector<double> masses;
  for (std::uint32_t j = 0; j <= grid.rows; ++j)
    for (std::uint32_t i = 0; i <= grid.columns; ++i)
      masses.push_back(share(i, grid.columns) * share(j, grid.rows));
  return masses;
}

/// Adds the points with their texture coordinates. u is along +x, v along -z: the image is upright seen from
/// above with +x to the right.
void addClothPoints(const Grid& grid, const ClothSettings& settings, SpringNetwork& network) {
  for (std::uint32_t j = 0; j <= grid.rows; ++j) {
    for (std::uint32_t i = 0; i <= grid.columns; ++i) {
      const double u = static_cast<double>(i) / grid.columns, v = static_cast<double>(j) / grid.rows;
      network.restPoints.emplace_back(settings.width * (u - 0.5), 0.0, settings.depth * (v - 0.5));
      network.render.uvs.emplace_back(static_cast<float>(u), static_cast<float>(1.0 - v));
    }
  }
}

}  // namespace

Result<SharedNetwork> buildCloth(const ClothSettings& settings) {
  if (std::string reason = check(settings); !reason.empty()) return Error{std::move(reason)};
  const Grid grid{settings.columns, settings.rows};
  auto network = std::make_shared<SpringNetwork>();
  network->kind = NetworkKind::Cloth;
  addClothPoints(grid, settings, *network);
  network->springs = clothSprings(grid, settings);
  network->thickness = settings.thickness;
  network->surface = clothTriangles(grid);
  network->massFractions = clothMasses(grid, settings.masses);
  network->render.vertexToPoint.resize(grid.points());
  std::iota(network->render.vertexToPoint.begin(), network->render.vertexToPoint.end(), 0u);
  network->render.triangles = network->surface;
  return SharedNetwork(std::move(network));
}

namespace {

/// Lengths with a smaller relative difference are equal. It is far above the rounding of the floats in mesh
/// files and far below the differences that a modeller makes on purpose.
constexpr double kEqualLength = 1e-5;

/// Returns the lengths of the springs, ascending.
std::vector<double> lengthsOf(const SpringNetwork& network) {
  std::vector<double> lengths;
  for (const NetworkSpring& s : network.springs)
    lengths.push_back((network.restPoints[s.a] - network.restPoints[s.b]).norm());
  std::sort(lengths.begin(), lengths.end());
  return lengths;
}

double squaredLimit(double length, double difference) {
  const double limit = length * (1.0 + difference);
  return limit * limit;
}

/// Returns whether a distance equals one of the ascending lengths.
bool contains(const std::vector<double>& lengths, double squaredDistance) {
  const auto next =
      std::lower_bound(lengths.begin(), lengths.end(), squaredDistance,
                       [](double length, double s) { return squaredLimit(length, kEqualLength) < s; });
  return next != lengths.end() && squaredLimit(*next, -kEqualLength) <= squaredDistance;
}

/// Returns the points sorted along the longest axis of the body, where a window of the length of the longest
/// edge contains the fewest points.
std::vector<std::uint32_t> sortAlongLongestAxis(const std::vector<Eigen::Vector3d>& points,
                                                Eigen::Index& axis) {
  boxOf(points).sizes().maxCoeff(&axis);
  std::vector<std::uint32_t> order(points.size());
  std::iota(order.begin(), order.end(), 0u);
  std::sort(order.begin(), order.end(), [&](std::uint32_t i, std::uint32_t j) {
    return points[i][axis] != points[j][axis] ? points[i][axis] < points[j][axis] : i < j;
  });
  return order;
}

/// Returns all pairs of points without a spring whose distance equals the length of some spring, sorted.
std::vector<Edge> findEqualLengthPairs(const SpringNetwork& network) {
  std::vector<Edge> pairs;
  if (network.springs.empty()) return pairs;
  const std::vector<Eigen::Vector3d>& points = network.restPoints;
  const std::vector<double> lengths = lengthsOf(network);
  const double maxLength = std::sqrt(squaredLimit(lengths.back(), kEqualLength));
  Eigen::Index axis = 0;
  const std::vector<std::uint32_t> order = sortAlongLongestAxis(points, axis);

  for (std::size_t i = 0; i < order.size(); ++i) {
    const Eigen::Vector3d& p = points[order[i]];
    for (std::size_t j = i + 1; j < order.size() && points[order[j]][axis] - p[axis] <= maxLength; ++j) {
      if (!contains(lengths, (points[order[j]] - p).squaredNorm())) continue;
      const Edge pair = edgeBetween(order[i], order[j]);
      if (!hasSpring(network, pair)) pairs.push_back(pair);
    }
  }
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

std::string checkSettings(const NetworkSettings& s) {
  const auto finite = [](double value) { return std::isfinite(value); };
  if (s.braceWeight && !(finite(*s.braceWeight) && *s.braceWeight > 0.0))
    return "braceWeight is " + std::to_string(*s.braceWeight) + ", must be above 0";
  if (!finite(s.maxBracesPerPoint) || s.maxBracesPerPoint <= 0.0)
    return "maxBracesPerPoint is " + std::to_string(s.maxBracesPerPoint) + ", must be above 0";
  if (!finite(s.timeLimit) || s.timeLimit < 0.0)
    return "timeLimit is " + std::to_string(s.timeLimit) + ", must be 0 or more";
  if (s.braces > BraceRule::Pipeline) return "braces is no value of BraceRule";
  if (s.masses > MassRule::Moments) return "masses is no value of MassRule";
  return {};
}

/// A connected piece of a mesh.
struct MeshPiece {
  SpringNetwork network;              ///< its points, edges and surface
  std::vector<std::uint32_t> ofMesh;  ///< #points, their indices in the mesh, ascending
};

MeshPiece makePiece(const WeldedMesh& welded, std::vector<Triangle> triangles) {
  MeshPiece piece;
  for (const Triangle& t : triangles) piece.ofMesh.insert(piece.ofMesh.end(), t.begin(), t.end());
  sortUnique(piece.ofMesh);
  for (Triangle& t : triangles)
    for (std::uint32_t& corner : t)
      corner = static_cast<std::uint32_t>(std::lower_bound(piece.ofMesh.begin(), piece.ofMesh.end(), corner) -
                                          piece.ofMesh.begin());
  piece.network.restPoints = chosen(welded.points, piece.ofMesh);
  for (const Edge& e : uniqueEdges(triangles))
    piece.network.springs.push_back({e[0], e[1], SpringKind::Structural, 1.0});
  piece.network.surface = std::move(triangles);
  return piece;
}

/// Returns a progress function with the time limit. Once it has returned false, it always returns false.
Progress progressWithTimeLimit(const NetworkSettings& settings) {
  using Clock = std::chrono::steady_clock;
  return [&settings, begin = Clock::now(), going = true](const char* what, double done) mutable {
    const double seconds = std::chrono::duration<double>(Clock::now() - begin).count();
    going = going && (settings.timeLimit == 0.0 || seconds < settings.timeLimit) &&
            (!settings.progress || settings.progress(what, done));
    return going;
  };
}

std::vector<Edge> findBraces(const SpringNetwork& piece, const NetworkSettings& settings,
                             const Progress& goOn) {
  switch (settings.braces) {
    case BraceRule::None:
      return {};
    case BraceRule::EqualLength:
      return findEqualLengthPairs(piece);
    case BraceRule::TwoRing:
      return findTwoRingPairs(piece);
    case BraceRule::Pipeline:
      return bracePiece(piece, settings, goOn);
  }
  return {};
}

/// Returns the edges and, within each component, the braces.
std::vector<NetworkSpring> connect(const WeldedMesh& welded, const NetworkSettings& settings) {
  std::vector<NetworkSpring> springs;
  const Progress goOn = progressWithTimeLimit(settings);
  for (std::vector<Triangle>& triangles : trianglesOfPieces(welded.points.size(), welded.triangles)) {
    const MeshPiece piece = makePiece(welded, std::move(triangles));
    const auto add = [&](std::uint32_t a, std::uint32_t b, SpringKind kind, double stiffnessScale) {
      springs.push_back({piece.ofMesh[a], piece.ofMesh[b], kind, stiffnessScale});
    };
    for (const NetworkSpring& s : piece.network.springs) add(s.a, s.b, s.kind, s.stiffnessScale);
    for (const Edge& pair : findBraces(piece.network, settings, goOn))
      add(pair[0], pair[1], SpringKind::Brace, braceWeight(settings));
  }
  std::sort(springs.begin(), springs.end(), isBefore);
  return springs;
}

}  // namespace

Result<SharedNetwork> buildNetwork(const TriangleMesh& mesh, const NetworkSettings& settings) {
  const std::string reason = checkSettings(settings);
  if (!reason.empty()) return Error{reason};
  Result<WeldedMesh> welded = weld(mesh, settings.weldTolerance);
  if (!welded) return Error{welded.error()};

  const std::vector<bool> inward = facingInward(welded->points, welded->triangles);
  flip(welded->triangles, inward);
  auto network = std::make_shared<SpringNetwork>();
  network->kind = NetworkKind::Solid;
  network->springs = connect(*welded, settings);
  network->massFractions = massFractions(settings.masses, welded->points, welded->triangles);
  network->render = makeRenderSurface(mesh, *welded);
  flip(network->render.triangles, inward);
  network->report = welded->report;
  network->restPoints = std::move(welded->points);
  network->surface = std::move(welded->triangles);
  return SharedNetwork(std::move(network));
}

}  // namespace limber
