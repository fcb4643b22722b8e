// SPDX-License-Identifier: Zlib

// This file finds faces, neighbours, volumes and angles of tetrahedra, and makes the surface of a tetrahedral
// mesh a manifold. It fills the inside of a surface with tetrahedra: searches a suitable lattice, has it
// filled and repaired, and moves the points at the surface to its edges and corners.

#include "network/tetrahedra.h"

#include "mesh/linear_algebra.h"

#include <tuple>

namespace limber {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// Returns the face opposite to a corner, counter-clockwise seen from outside.
Triangle faceOf(const Tetrahedron& t, std::size_t corner) {
  switch (corner) {
    case 0:
      return {t[1], t[2], t[3]};
    case 1:
      return {t[0], t[3], t[2]};
    case 2:
      return {t[0], t[1], t[3]};
    default:
      return {t[0], t[2], t[1]};
  }
}

/// A face by its corners in ascending order, and 4 x its tetrahedron + the opposite corner.
using Face = std::pair<Triangle, std::uint32_t>;

/// Returns all faces in ascending order: first by counts of the lowest corner, then a few at a time.
std::vector<Face> sortedFaces(const std::vector<Tetrahedron>& tetrahedra) {
  std::uint32_t points = 0;
  for (const Tetrahedron& t : tetrahedra)
    points = std::max(points, *std::max_element(t.begin(), t.end()) + 1);
  std::vector<std::uint32_t> end(points + 1, 0);  // of the faces of each lowest corner
  std::vector<Face> unsorted, faces;
  unsorted.reserve(4 * tetrahedra.size());
  for (std::uint32_t t = 0; t < tetrahedra.size(); ++t)
    for (std::uint32_t corner = 0; corner < 4; ++corner) {
      Triangle face = faceOf(tetrahedra[t], corner);
      std::sort(face.begin(), face.end());
      unsorted.emplace_back(face, 4 * t + corner);
      ++end[face[0] + 1];
    }
  std::partial_sum(end.begin(), end.end(), end.begin());
  faces.resize(unsorted.size());
  for (const Face& face : unsorted) faces[end[face.first[0]]++] = face;
  for (std::uint32_t i = 0, first = 0; i < points; first = end[i++])
    std::sort(faces.begin() + first, faces.begin() + end[i]);
  return faces;
}

}  // namespace

FaceNeighbours findFaceNeighbours(const std::vector<Tetrahedron>& tetrahedra) {
  const std::vector<Face> faces = sortedFaces(tetrahedra);
  FaceNeighbours neighbours(tetrahedra.size(), {kOutside, kOutside, kOutside, kOutside});
  for (std::size_t i = 1; i < faces.size(); ++i) {
    if (faces[i].first != faces[i - 1].first) continue;
    const std::uint32_t a = faces[i - 1].second, b = faces[i].second;
    neighbours[a / 4][a % 4] = b / 4;
    neighbours[b / 4][b % 4] = a / 4;
  }
  return neighbours;
}

std::vector<Triangle> surfaceOf(const std::vector<Tetrahedron>& tetrahedra,
                                const FaceNeighbours& neighbours) {
  std::vector<Triangle> surface;
  for (std::size_t t = 0; t < tetrahedra.size(); ++t)
    for (std::size_t corner = 0; corner < 4; ++corner)
      if (neighbours[t][corner] == kOutside) surface.push_back(faceOf(tetrahedra[t], corner));
  return surface;
}

std::vector<Edge> uniqueEdges(const std::vector<Tetrahedron>& tetrahedra) {
  std::vector<Edge> edges;
  for (const Tetrahedron& t : tetrahedra)
    for (std::size_t i = 0; i < 4; ++i)
      for (std::size_t j = i + 1; j < 4; ++j) edges.push_back(edgeBetween(t[i], t[j]));
  sortUnique(edges);
  return edges;
}

double volumeOf(const std::vector<Vector3d>& points, const Tetrahedron& t) {
  const Vector3d& a = points[t[0]];
  return (points[t[1]] - a).dot((points[t[2]] - a).cross(points[t[3]] - a)) / 6.0;
}

double volumeOf(const std::vector<Vector3d>& points, const std::vector<Tetrahedron>& tetrahedra) {
  double volume = 0.0;
  for (const Tetrahedron& t : tetrahedra) volume += volumeOf(points, t);
  return volume;
}

DihedralAngles dihedralAngles(const std::vector<Vector3d>& points, const Tetrahedron& t) {
  std::array<Vector3d, 4> normals;
  for (std::size_t i = 0; i < 4; ++i) normals[i] = areaVector(points, faceOf(t, i)).normalized();
  DihedralAngles angles{3.2, 0.0};
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t j = i + 1; j < 4; ++j) {
      const double angle = std::acos(std::clamp(-normals[i].dot(normals[j]), -1.0, 1.0));
      angles.smallest = std::min(angles.smallest, angle);
      angles.largest = std::max(angles.largest, angle);
    }
  return angles;
}

namespace {

using Indices = std::vector<std::uint32_t>;

/// Groups the `subset` (ascending) of tetrahedra: faces that contain all points of `hub` join them. Returns
/// for each one the first member of its group, as an index into `subset`.
Indices groupAround(const std::vector<Tetrahedron>& tetrahedra, const FaceNeighbours& neighbours,
                    const Indices& subset, const Indices& hub) {
  DisjointSets groups(subset.size());
  for (std::uint32_t i = 0; i < subset.size(); ++i)
    for (std::size_t corner = 0; corner < 4; ++corner) {
      const std::uint32_t t = subset[i], other = neighbours[t][corner];
      const bool containsHub = std::find(hub.begin(), hub.end(), tetrahedra[t][corner]) == hub.end();
      const auto found = std::lower_bound(subset.begin(), subset.end(), other);
      if (containsHub && found != subset.end() && *found == other)
        groups.join(i, static_cast<std::uint32_t>(found - subset.begin()));
    }
  Indices firsts;
  for (std::uint32_t i = 0; i < subset.size(); ++i) firsts.push_back(groups.root(i));
  return firsts;
}

/// Returns the edges of more than two triangles of the surface.
std::vector<Edge> nonManifoldEdges(const std::vector<Triangle>& surface) {
  std::vector<Edge> nonManifold;
  forEachEdge(surface, [&](const Side* sides, std::size_t uses) {
    if (uses > 2) nonManifold.push_back(sides->edge);
  });
  return nonManifold;
}

void removeMarked(std::vector<Tetrahedron>& tetrahedra, const std::vector<char>& marked) {
  std::size_t kept = 0;
  for (std::size_t t = 0; t < tetrahedra.size(); ++t)
    if (!marked[t]) tetrahedra[kept++] = tetrahedra[t];
  tetrahedra.resize(kept);
}

/// Marks all groups except the one of the largest volume.
void markSmaller(const TetrahedralMesh& mesh, const Indices& subset, const Indices& group,
                 std::vector<char>& marked) {
  std::vector<double> volume(subset.size(), 0.0);
  for (std::size_t i = 0; i < subset.size(); ++i)
    volume[group[i]] += volumeOf(mesh.points, mesh.tetrahedra[subset[i]]);
  const auto largest = std::max_element(volume.begin(), volume.end()) - volume.begin();
  for (std::size_t i = 0; i < subset.size(); ++i)
    if (group[i] != largest) marked[subset[i]] = 1;
}

/// Returns true if there was nothing to remove.
bool removeAtNonManifoldEdges(TetrahedralMesh& mesh) {
  const FaceNeighbours neighbours = findFaceNeighbours(mesh.tetrahedra);
  const std::vector<Edge> nonManifold = nonManifoldEdges(surfaceOf(mesh.tetrahedra, neighbours));
  if (nonManifold.empty()) return true;
  const std::vector<Indices> at = elementsOfPoints(mesh.points.size(), mesh.tetrahedra);
  std::vector<char> marked(mesh.tetrahedra.size(), 0);
  for (const Edge& edge : nonManifold) {
    Indices subset;
    for (const std::uint32_t t : at[edge[0]]) {
      const Tetrahedron& corners = mesh.tetrahedra[t];
      if (std::find(corners.begin(), corners.end(), edge[1]) != corners.end()) subset.push_back(t);
    }
    markSmaller(mesh, subset, groupAround(mesh.tetrahedra, neighbours, subset, {edge[0], edge[1]}), marked);
  }
  removeMarked(mesh.tetrahedra, marked);
  return false;
}

void splitPoints(TetrahedralMesh& mesh) {
  const FaceNeighbours neighbours = findFaceNeighbours(mesh.tetrahedra);
  const std::vector<Indices> at = elementsOfPoints(mesh.points.size(), mesh.tetrahedra);
  for (std::uint32_t point = 0; point < at.size(); ++point) {
    const Indices group = groupAround(mesh.tetrahedra, neighbours, at[point], {point});
    for (std::uint32_t first = 1; first < group.size(); ++first) {
      if (group[first] != first) continue;
      for (std::size_t i = first; i < group.size(); ++i) {
        Tetrahedron& t = mesh.tetrahedra[at[point][i]];
        if (group[i] == first)
          std::replace(t.begin(), t.end(), point, static_cast<std::uint32_t>(mesh.points.size()));
      }
      mesh.points.push_back(mesh.points[point]);
    }
  }
}

void removeSmallPieces(TetrahedralMesh& mesh, double minVolume) {
  const Indices piece = findPieces(mesh.tetrahedra);
  std::vector<double> volume(piece.size(), 0.0);
  for (std::size_t t = 0; t < piece.size(); ++t)
    volume[piece[t]] += volumeOf(mesh.points, mesh.tetrahedra[t]);
  std::vector<char> marked(piece.size(), 0);
  for (std::size_t t = 0; t < piece.size(); ++t) marked[t] = volume[piece[t]] < minVolume;
  removeMarked(mesh.tetrahedra, marked);
}

void dropUnusedPoints(TetrahedralMesh& mesh) {
  Renumbering numbers(mesh.points.size());
  for (const std::uint32_t point : usedPoints(mesh.points.size(), mesh.tetrahedra)) numbers(point);
  mesh.points = chosen(mesh.points, numbers.kept());
  for (Tetrahedron& t : mesh.tetrahedra) t = numbers(t);
}

}  // namespace

std::vector<std::uint32_t> findPieces(const std::vector<Tetrahedron>& tetrahedra) {
  const FaceNeighbours neighbours = findFaceNeighbours(tetrahedra);
  DisjointSets sets(tetrahedra.size());
  for (std::uint32_t t = 0; t < tetrahedra.size(); ++t)
    for (const std::uint32_t other : neighbours[t])
      if (other != kOutside) sets.join(t, other);
  Renumbering numbers(tetrahedra.size());
  Indices piece;
  for (std::uint32_t t = 0; t < tetrahedra.size(); ++t) piece.push_back(numbers(sets.root(t)));
  return piece;
}

void separatePoints(TetrahedralMesh& mesh) {
  constexpr double kMoved = 0.05;  // of the way to the middle of the tetrahedra
  const std::vector<Vector3d> places = mesh.points;
  const std::vector<Indices> at = elementsOfPoints(places.size(), mesh.tetrahedra);
  Indices order(places.size());
  std::iota(order.begin(), order.end(), 0u);
  const auto key = [&](std::uint32_t i) {
    return std::make_tuple(places[i].x(), places[i].y(), places[i].z());
  };
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) { return key(a) < key(b); });
  const auto isSame = [&](std::size_t i, std::size_t j) { return places[order[i]] == places[order[j]]; };
  for (std::size_t i = 0; i < order.size(); ++i) {
    if (!(i + 1 < order.size() && isSame(i, i + 1)) && !(i > 0 && isSame(i, i - 1))) continue;
    const std::uint32_t point = order[i];
    Vector3d sum = Vector3d::Zero();
    for (const std::uint32_t t : at[point])
      for (const std::uint32_t corner : mesh.tetrahedra[t]) sum += 0.25 * (places[corner] - places[point]);
    mesh.points[point] += kMoved / static_cast<double>(at[point].size()) * sum;
  }
}

void makeManifold(TetrahedralMesh& mesh, double minVolume) {
  while (!removeAtNonManifoldEdges(mesh)) {
  }
  removeSmallPieces(mesh, minVolume);
  splitPoints(mesh);
  dropUnusedPoints(mesh);
  mesh.surface = surfaceOf(mesh.tetrahedra, findFaceNeighbours(mesh.tetrahedra));
}

// --- filling a surface -------------------------------------------------------------------------------------

namespace {

/// A closed surface that faces outward.
struct SolidSurface {
  std::vector<Vector3d> points;
  std::vector<Triangle> triangles;
  SurfaceComponents pieces;  ///< they share no point
  TriangleBvh bvh;
  Eigen::AlignedBox3d box;
  double volume = 0.0;  ///< m^3

  Vector3d normal(std::size_t triangle) const { return areaVector(points, triangles[triangle]).normalized(); }
};

/// Returns the reason why the mesh has no inside, or an empty string.
std::string whyNotSolid(const MeshReport& report) {
  if (report.openEdges > 0)
    return "the mesh is not closed: it has " + std::to_string(report.openEdges) +
           " open edges; wrap() closes it, cook() does so by itself";
  if (report.inconsistentEdges > 0)
    return "the mesh has no inside: at " + std::to_string(report.inconsistentEdges) +
           " edges its triangles are oriented against each other; wrap() orients them";
  return {};
}

SolidSurface makeSolidSurface(const WeldedMesh& mesh) {
  const std::vector<Triangle> triangles = facingOutward(mesh.points, mesh.triangles);
  return {mesh.points,
          triangles,
          findComponents(mesh.points.size(), triangles),
          TriangleBvh(mesh.points, triangles),
          boxOf(mesh.points),
          signedVolume(mesh.points, triangles)};
}

/// The smallest and the largest angle (degrees) that fitSurface() may produce, unless they were worse before.
constexpr double kSmallestAngle = 18.0, kLargestAngle = 145.0;

/// Rounds over all points.
constexpr int kRounds = 6;

/// Weight of the distance from the present position, relative to the planes: it only has an effect along
/// directions that no plane determines.
constexpr double kPositionWeight = 0.05;

struct Fit {
  TetrahedralMesh& mesh;
  std::vector<std::vector<std::uint32_t>> tetrahedraAt, trianglesAt;  ///< of each point
};

/// Returns the smallest margin of the angles at a point to their bounds, radians: negative outside, -10 for
/// an inverted tetrahedron.
double slack(const Fit& fit, std::uint32_t point) {
  double minSlack = kPi;
  for (const std::uint32_t i : fit.tetrahedraAt[point]) {
    const Tetrahedron& t = fit.mesh.tetrahedra[i];
    if (volumeOf(fit.mesh.points, t) <= 0.0) return -10.0;
    const DihedralAngles angles = dihedralAngles(fit.mesh.points, t);
    minSlack = std::min({minSlack, angles.smallest - kSmallestAngle * kPi / 180.0,
                         kLargestAngle * kPi / 180.0 - angles.largest});
  }
  return minSlack;
}

/// Moves the point towards `target` as far as the angles stay within bounds, or do not become worse.
void moveTowards(Fit& fit, std::uint32_t point, const Vector3d& target) {
  const Vector3d from = fit.mesh.points[point];
  const double minSlack = std::min(0.0, slack(fit, point));
  for (const double fraction : {1.0, 0.5, 0.25}) {
    fit.mesh.points[point] = from + fraction * (target - from);
    if (slack(fit, point) >= minSlack) return;
  }
  fit.mesh.points[point] = from;
}

/// Returns the intersection of the planes of the surface next to the triangles around a point.
Vector3d intersectPlanes(const Fit& fit, std::uint32_t point, const SolidSurface& surface) {
  const std::vector<Vector3d>& points = fit.mesh.points;
  const Vector3d& position = points[point];
  Matrix3d left = Matrix3d::Zero();
  Vector3d right = Vector3d::Zero();
  double area = 0.0;
  for (const std::uint32_t i : fit.trianglesAt[point]) {
    const Triangle& t = fit.mesh.surface[i];
    const double weight = 2.0 * areaVector(points, t).norm();
    for (std::size_t corner = 0; corner < 3; ++corner) {
      const Vector3d sample = (points[t[0]] + points[t[1]] + points[t[2]] + 3.0 * points[t[corner]]) / 6.0;
      const TriangleHit hit = surface.bvh.nearest(sample);
      const Vector3d normal = surface.normal(hit.triangle);
      left += weight * normal * normal.transpose();
      right += weight * normal.dot(hit.position - position) * normal;
    }
    area += weight;
  }
  left += kPositionWeight * area * Matrix3d::Identity();
  solveSmall(left, right);
  return position + right;
}

Vector3d meanOfNeighbours(const Fit& fit, std::uint32_t point) {
  Vector3d sum = Vector3d::Zero();
  double weight = 0.0;
  for (const std::uint32_t i : fit.tetrahedraAt[point]) {
    const Tetrahedron& t = fit.mesh.tetrahedra[i];
    const double volume = volumeOf(fit.mesh.points, t);
    for (const std::uint32_t corner : t) sum += 0.25 * volume * fit.mesh.points[corner];
    weight += volume;
  }
  return sum / weight;
}

/// Moves the points of the surface to the intersections of the planes of the given surface around them (by
/// the least squares of M. Garland, P. Heckbert, "Surface simplification using quadric error metrics",
/// SIGGRAPH 1997). This restores sharp edges and corners, which the lattice cuts off, and the volume of round
/// bodies. Spreads the points inside evenly. Points move one after the other, as far as the angles allow.
void fitSurface(TetrahedralMesh& mesh, const SolidSurface& surface) {
  Fit fit{mesh, elementsOfPoints(mesh.points.size(), mesh.tetrahedra),
          elementsOfPoints(mesh.points.size(), mesh.surface)};
  for (int round = 0; round < kRounds; ++round)
    for (std::uint32_t point = 0; point < mesh.points.size(); ++point)
      moveTowards(fit, point,
                  fit.trianglesAt[point].empty() ? meanOfNeighbours(fit, point)
                                                 : intersectPlanes(fit, point, surface));
}

/// Largest number of sites: their arrays take about 60 bytes each.
constexpr double kMaxSites = 4e6;

/// A part of the body with less than this fraction of a piece's volume may be removed.
constexpr double kCrumbFraction = 0.01;

/// Limits of the stretching of the lattice along an axis: flat lattices have sharp angles.
constexpr double kMinStretch = 0.8, kMaxStretch = 1.25;

/// Number of spacings that are tried for a number of points, unless the body falls apart on the first ones.
constexpr double kUsualTrials = 9.0;

/// A surface that encloses less than this fraction of its box is flat.
constexpr double kMinVolume = 1e-6;
constexpr char kNoVolume[] = "the mesh encloses no volume";

/// Weight of the missing volume before the fit relative to the error of the number of points, both as
/// logarithms. A lattice that is well aligned with the body is worth an error of some points. An L with arms
/// of 2 x 2 cells on the lattice has, before calibration, 0.95 of the modulus of a fine one; with a fifth
/// more points in a lattice that is not aligned it has two thirds.
constexpr double kVolumeWeight = 8.0;

/// Beyond this logarithm of the error, a factor of 1.5, points count as much as volume.
constexpr double kLargeDeviation = 0.4;

/// Places whole cells across the box where this stretches them little, so that flat sides of boxes lie in the
/// lattice.
BccLattice placeLattice(const Eigen::AlignedBox3d& box, double spacing) {
  BccLattice lattice;
  for (int i = 0; i < 3; ++i) {
    const double extent = box.sizes()[i], cells = std::max(1.0, std::round(extent / spacing));
    lattice.spacing[i] = std::clamp(extent / cells, kMinStretch * spacing, kMaxStretch * spacing);
    lattice.cells[i] = static_cast<int>(cells) + 5;
    lattice.origin[i] = box.center()[i] - (0.5 * cells + 2.0) * lattice.spacing[i];
  }
  return lattice;
}

double sitesNeeded(const Eigen::AlignedBox3d& box, double spacing) {
  return 2.0 * (box.sizes().array() / spacing + 6.0).prod();
}

/// Counts, for each part of the body, the points of its surface that are next to each piece of the given
/// surface, #parts x #pieces.
Eigen::MatrixXi countNearPoints(const TetrahedralMesh& mesh, const SolidSurface& surface) {
  const std::vector<std::uint32_t> partOfTetrahedron = findPieces(mesh.tetrahedra);
  std::vector<std::uint32_t> partOfPoint(mesh.points.size());
  std::uint32_t parts = 0;
  for (std::size_t t = 0; t < mesh.tetrahedra.size(); ++t) {
    parts = std::max(parts, partOfTetrahedron[t] + 1);
    for (const std::uint32_t point : mesh.tetrahedra[t]) partOfPoint[point] = partOfTetrahedron[t];
  }
  Eigen::MatrixXi count = Eigen::MatrixXi::Zero(parts, static_cast<Eigen::Index>(surface.pieces.count));
  for (const std::uint32_t i : usedPoints(mesh.points.size(), mesh.surface))
    ++count(partOfPoint[i], surface.pieces.ofTriangle[surface.bvh.nearest(mesh.points[i]).triangle]);
  return count;
}

/// Returns whether the inside is on both sides of the piece, so that it is not part of the body's surface.
bool isBuried(const SolidSurface& surface, std::uint32_t piece) {
  const double step = 1e-4 * surface.box.diagonal().norm();
  for (std::size_t t = 0; t < surface.triangles.size(); ++t)
    if (surface.pieces.ofTriangle[t] == piece &&
        !surface.bvh.inside(centroid(surface.points, surface.triangles[t]) + step * surface.normal(t)))
      return false;
  return true;
}

/// Describes the part of the mesh that the tetrahedra do not represent; empty if there is none.
std::string findLoss(const TetrahedralMesh& mesh, const SolidSurface& surface) {
  if (mesh.tetrahedra.empty()) return "the whole mesh is missed";
  const Eigen::MatrixXi count = countNearPoints(mesh, surface);
  for (std::uint32_t piece = 0; piece < surface.pieces.count; ++piece)
    if (count.col(piece).maxCoeff() == 0 && !isBuried(surface, piece))
      return "piece " + std::to_string(piece) + " of the mesh is missed";
  std::vector<Eigen::Index> mainPart(surface.pieces.count, -1);
  for (Eigen::Index part = 0; part < count.rows(); ++part) {
    Eigen::Index piece = 0;
    count.row(part).maxCoeff(&piece);
    Eigen::Index& firstPart = mainPart[static_cast<std::size_t>(piece)];
    if (firstPart >= 0) return "piece " + std::to_string(piece) + " of the mesh falls apart";
    firstPart = part;
  }
  return {};
}

/// A filling that is not yet fitted to the surface, and its errors.
struct Trial {
  TetrahedralMesh mesh;
  double spacing = 0.0;
  std::string loss;
  double logRatio = 0.0;  ///< of the number of points over the requested one
  double penalty = 0.0;   ///< 0 is the best
};

Trial fillAt(const SolidSurface& surface, double spacing, double points) {
  Trial trial;
  trial.mesh = fillLattice(placeLattice(surface.box, spacing), surface.bvh);
  makeManifold(trial.mesh, kCrumbFraction * surface.volume / static_cast<double>(surface.pieces.count));
  trial.spacing = spacing;
  trial.loss = findLoss(trial.mesh, surface);
  const double volume = volumeOf(trial.mesh.points, trial.mesh.tetrahedra);
  trial.logRatio = std::log(static_cast<double>(std::max<std::size_t>(1, trial.mesh.points.size())) / points);
  const double deviation = std::abs(trial.logRatio), excess = std::max(0.0, deviation - kLargeDeviation);
  trial.penalty = deviation + kVolumeWeight * (excess + std::abs(std::log(volume / surface.volume)));
  return trial;
}

void keepBetter(Trial& best, Trial trial) {
  const bool isBetter =
      best.loss.empty() == trial.loss.empty() ? trial.penalty < best.penalty : trial.loss.empty();
  if (isBetter || best.spacing == 0.0) best = std::move(trial);
}

/// Lattices with more points than this many times the requested number are not tried.
constexpr double kMostPoints = 1000.0;

/// Searches the spacing for about this many points. There are two points for each cube of the lattice, and
/// those of the surface, so the number depends on the spacing with a power between 2 and 3. It jumps where
/// several rows are added at once.
Trial searchSpacing(const SolidSurface& surface, double points, const std::function<bool(double)>& goOn) {
  const double finest = std::cbrt(2.0 * surface.volume / (kMostPoints * points));
  double spacing = std::cbrt(3.0 * surface.volume / points);
  Trial best;
  int tried = 0;
  const auto attempt = [&](double trialSpacing) {
    if (goOn && !goOn(std::min(1.0, tried++ / kUsualTrials))) return 0.0;
    if (sitesNeeded(surface.box, trialSpacing) > kMaxSites) return 0.0;
    Trial trial = fillAt(surface, trialSpacing, points);
    const double logRatio = trial.logRatio;
    keepBetter(best, std::move(trial));
    return logRatio;
  };
  for (int i = 0; i < 5; ++i) spacing = std::max(finest, spacing * std::exp(attempt(spacing) / 2.6));
  const double baseSpacing = best.spacing;
  for (const double factor : {0.9, 0.95, 1.05, 1.1}) attempt(factor * baseSpacing);
  const double last = std::max(finest, 0.5 * baseSpacing);
  for (double finer = 0.85 * baseSpacing; !best.loss.empty() && finer > last; finer *= 0.95) attempt(finer);
  return best;
}

bool isFlat(const SolidSurface& surface) { return surface.volume <= kMinVolume * surface.box.volume(); }

Result<TetrahedralMesh> finish(Trial trial, const SolidSurface& fit) {
  if (trial.spacing == 0.0) return Error{"so many points need a lattice that is too large"};
  if (!trial.loss.empty())
    return Error{trial.loss + ": it is thinner than a lattice of " + inThreeDigits(trial.spacing) +
                 " m can follow, or oriented inward; take a smaller spacing or more points"};
  fitSurface(trial.mesh, fit);
  separatePoints(trial.mesh);
  return std::move(trial.mesh);
}

}  // namespace

Result<TetrahedralMesh> fillWithTetrahedra(const WeldedMesh& mesh, double spacing, const WeldedMesh* fit) {
  if (std::string reason = whyNotSolid(mesh.report); !reason.empty()) return Error{std::move(reason)};
  if (!std::isfinite(spacing) || spacing <= 0.0)
    return Error{"the spacing is " + inThreeDigits(spacing) + ", it must be above 0"};
  const SolidSurface surface = makeSolidSurface(mesh);
  if (isFlat(surface)) return Error{kNoVolume};
  if (const double sites = sitesNeeded(surface.box, spacing); sites > kMaxSites)
    return Error{"the spacing of " + inThreeDigits(spacing) + " m needs a lattice of " +
                 inThreeDigits(sites) + " sites, it may have " + inThreeDigits(kMaxSites)};
  Trial trial = fillAt(surface, spacing, 1.0);
  return finish(std::move(trial), fit ? makeSolidSurface(*fit) : surface);
}

Result<TetrahedralMesh> fillWithPoints(const WeldedMesh& mesh, std::size_t points,
                                       const std::function<bool(double)>& goOn) {
  if (std::string reason = whyNotSolid(mesh.report); !reason.empty()) return Error{std::move(reason)};
  if (points < 8) return Error{std::to_string(points) + " points are too few, there must be 8 or more"};
  const SolidSurface surface = makeSolidSurface(mesh);
  if (isFlat(surface)) return Error{kNoVolume};
  return finish(searchSpacing(surface, static_cast<double>(points), goOn), surface);
}

}  // namespace limber
