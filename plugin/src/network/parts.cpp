// SPDX-License-Identifier: Zlib
// Splits meshes into parts that become bodies, and wraps parts. Recognises parts that are sheets or thin
// tubes, and makes cloths and ropes of them.

#include "network/parts.h"

#include "mesh/linear_algebra.h"
#include "mesh/surface.h"
#include "mesh/triangle_bvh.h"
#include "network/bracing.h"
#include "network/material.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

namespace limber {

// --- parts -------------------------------------------------------------------------------------------------

namespace {

/// Largest number of bodies. Meshes of more pieces, such as trees with leaves, are one body.
constexpr std::size_t kMaxBodies = 32;

/// Parts smaller than this fraction of the largest are left out.
constexpr double kMinPartSize = 0.005;

/// The finest cells, as a share of the thickness that all parts of a wrap get: finer ones show nothing more.
constexpr double kCellsPerThickness = 14.0;

/// The pieces of a wrapped mesh that become bodies, the largest first.
struct Shells {
  std::vector<Triangle> triangles;
  std::vector<std::uint32_t> bodyOfTriangle;
  std::size_t bodies = 0;
};

Shells findShells(const TriangleMesh& wrapped) {
  const std::vector<std::vector<Triangle>> triangles =
      trianglesOfPieces(wrapped.positions.size(), wrapped.triangles);
  std::vector<double> volume;
  for (const auto& piece : triangles) volume.push_back(signedVolume(wrapped.positions, piece));
  std::vector<std::size_t> order(triangles.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return volume[a] > volume[b]; });
  Shells shells;
  for (const std::size_t piece : order) {
    if (volume[piece] <= 0.0) break;  // surfaces of hollows are negative
    shells.triangles.insert(shells.triangles.end(), triangles[piece].begin(), triangles[piece].end());
    shells.bodyOfTriangle.resize(shells.triangles.size(), static_cast<std::uint32_t>(shells.bodies++));
  }
  return shells;
}

/// Returns the body of each kept triangle of the mesh: that of the shell nearest to most vertices of its
/// component.
std::vector<std::uint32_t> bodyOfTriangles(const WeldedMesh& welded, const TriangleMesh& wrapped,
                                           const Shells& shells) {
  const TriangleBvh bvh(wrapped.positions, shells.triangles);
  const SurfaceComponents pieces = findComponents(welded.points.size(), welded.triangles);
  std::vector<std::map<std::uint32_t, std::size_t>> votes(pieces.count);  // of each piece for bodies
  for (std::size_t t = 0; t < welded.triangles.size(); ++t)
    ++votes[pieces.ofTriangle[t]]
           [shells.bodyOfTriangle[bvh.nearest(welded.points[welded.triangles[t][0]]).triangle]];
  std::vector<std::uint32_t> bodyOfPiece, body;
  for (const auto& v : votes)
    bodyOfPiece.push_back(std::max_element(v.begin(), v.end(), [](const auto& a, const auto& b) {
                            return a.second < b.second;
                          })->first);
  for (const std::uint32_t piece : pieces.ofTriangle) body.push_back(bodyOfPiece[piece]);
  return body;
}

/// Returns the longest sides (m) of the components' boxes.
std::vector<double> extentsOf(const SurfaceComponents& components, const WeldedMesh& welded) {
  std::vector<Eigen::AlignedBox3d> boxes(components.count);
  for (std::size_t t = 0; t < welded.triangles.size(); ++t)
    for (const std::uint32_t corner : welded.triangles[t])
      boxes[components.ofTriangle[t]].extend(welded.points[corner]);
  std::vector<double> extents;
  for (const Eigen::AlignedBox3d& box : boxes) extents.push_back(box.sizes().maxCoeff());
  return extents;
}

/// Returns the triangles without those of crumbs, as scans have them: pieces that are too small for a body,
/// and farther than `join` (m) from all larger ones.
std::vector<Triangle> withoutCrumbs(const TriangleMesh& mesh, const WeldedMesh& welded, double join) {
  const SurfaceComponents components = findComponents(welded.points.size(), welded.triangles);
  const std::vector<double> extents = extentsOf(components, welded);
  const double least = kMinPartSize * *std::max_element(extents.begin(), extents.end());
  const auto isSmall = [&](std::size_t t) { return extents[components.ofTriangle[t]] < least; };
  std::vector<Triangle> large, kept;
  for (std::size_t t = 0; t < welded.triangles.size(); ++t)
    if (!isSmall(t)) large.push_back(welded.triangles[t]);
  const TriangleBvh bvh(welded.points, large);
  std::vector<unsigned char> near(components.count, 0);
  for (std::size_t t = 0; t < welded.triangles.size(); ++t) {
    const Eigen::Vector3d& corner = welded.points[welded.triangles[t][0]];
    if (isSmall(t) && bvh.nearest(corner).distance <= join) near[components.ofTriangle[t]] = 1;
  }
  for (std::size_t t = 0; t < welded.triangles.size(); ++t)
    if (!isSmall(t) || near[components.ofTriangle[t]])
      kept.push_back(mesh.triangles[welded.keptTriangles[t]]);
  return kept;
}

void leaveOutTinyOnes(std::vector<Part>& parts) {
  double largest = 0.0;
  for (const Part& part : parts) largest = std::max(largest, extent(part.welded.points));
  const auto isTiny = [&](const Part& part) { return extent(part.welded.points) < kMinPartSize * largest; };
  parts.erase(std::remove_if(parts.begin(), parts.end(), isTiny), parts.end());
}

Result<Part> makePart(TriangleMesh mesh) {
  Result<WeldedMesh> welded = weld(mesh);
  if (!welded) return Error{welded.error()};
  return Part{std::move(mesh), std::move(*welded)};
}

}  // namespace

Result<std::vector<Part>> splitIntoParts(const TriangleMesh& mesh, const WrapSettings& settings,
                                         bool mayBeApart) {
  std::vector<Part> parts;
  Result<Part> whole = makePart(mesh);
  if (!whole) return Error{whole.error()};
  if (whole->welded.report.components > 1 && mayBeApart) {
    const double join = withDefaults(settings, extent(mesh)).join;
    std::vector<Triangle> kept = withoutCrumbs(mesh, whole->welded, join);
    if (kept.size() < whole->welded.triangles.size())
      return splitIntoParts(partOf(mesh, std::move(kept)), settings, mayBeApart);
    const Result<WrappedMesh> wrapped = wrapOfField(mesh, settings, "wrap.", 0.0);  // with small pieces
    if (!wrapped) return Error{wrapped.error()};
    const Shells shells = findShells(wrapped->mesh);
    std::map<std::uint32_t, std::vector<Triangle>> trianglesOf;  // by body
    if (shells.bodies > 1) {
      const std::vector<std::uint32_t> body = bodyOfTriangles(whole->welded, wrapped->mesh, shells);
      for (std::size_t t = 0; t < body.size(); ++t)
        trianglesOf[body[t]].push_back(mesh.triangles[whole->welded.keptTriangles[t]]);
    }
    if (trianglesOf.size() > 1 && trianglesOf.size() <= kMaxBodies) {
      for (auto& [body, triangles] : trianglesOf) {
        Result<Part> part = makePart(partOf(mesh, std::move(triangles)));
        if (!part) return Error{part.error()};
        parts.push_back(std::move(*part));
      }
      leaveOutTinyOnes(parts);
      return parts;
    }
  }
  parts.push_back(std::move(*whole));
  return parts;
}

Result<WeldedMesh> wrapOutside(const TriangleMesh& mesh, WrapSettings settings, double thickness) {
  settings.connect = true;
  if (settings.resolution == 0.0) {
    settings = withDefaults(settings, extent(mesh));
    settings.resolution = std::max(settings.resolution, thickness / kCellsPerThickness);
  }
  settings.thickness = std::max(settings.thickness, thickness);
  const Result<WrappedMesh> result = wrapOfField(mesh, settings, "wrap.");
  if (!result) return Error{result.error()};
  return weld(meshOf(result->mesh.positions, findShells(result->mesh).triangles));
}

namespace {

using Eigen::Vector3d;

// --- sheets ------------------------------------------------------------------------------------------------

/// Square of the border's length over the area: a disc has 12.6, a square 16, half a ball 6.3.
constexpr double kSheetBorder = 10.0;

/// A mesh is flat if its smallest extent is less than this fraction of its largest one.
constexpr double kFlat = 0.03;

/// Thickness of a sheet without one, as a fraction of its size.
constexpr double kSheetThickness = 0.005;

constexpr std::size_t kSheetPoints = 800;

/// Longest edge of a sheet, as a fraction of its size: longer ones cannot fold.
constexpr double kSheetEdge = 0.1;

/// Fraction of the area of a plate that faces along its normal or against it: for a flat ring of wire it is
/// 2/3.
constexpr double kPlateArea = 0.8;

/// Stiffness of the springs between second neighbours, which resist bending, relative to the edges.
constexpr double kSheetBending = 0.1;

/// Returns the length (m) of the edges of only one triangle.
double borderLength(const WeldedMesh& mesh) {
  double length = 0.0;
  forEachEdge(mesh.triangles, [&](const Side* sides, std::size_t uses) {
    if (uses == 1) length += (mesh.points[sides->edge[0]] - mesh.points[sides->edge[1]]).norm();
  });
  return length;
}

Vector3d sizeAlong(const Eigen::Matrix3d& axes, const std::vector<Vector3d>& points) {
  Eigen::AlignedBox3d box;
  for (const Vector3d& p : points) box.extend(Vector3d(axes.transpose() * p));
  return box.sizes();
}

/// Returns the axes turned about the third one.
Eigen::Matrix3d turned(const Eigen::Matrix3d& axes, double angle) {
  return axes * Eigen::AngleAxisd(angle, Vector3d::UnitZ()).toRotationMatrix();
}

/// Steps of the angle in the search for the smallest box, in a quarter turn, and halvings of the step.
constexpr int kAngles = 90, kAngleHalvings = 12;

}  // namespace

FlatBox flatBoxOf(const std::vector<Vector3d>& points) {
  Vector3d middle = Vector3d::Zero();
  for (const Vector3d& p : points) middle += p / static_cast<double>(points.size());
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  for (const Vector3d& p : points) spread += (p - middle) * (p - middle).transpose();
  const Vector3d normal = symmetricParts3(spread).vectors.col(0).normalized(),
                 along = normal.unitOrthogonal();
  Eigen::Matrix3d start;
  start << along, normal.cross(along), normal;
  const auto area = [&](double angle) {
    const Vector3d size = sizeAlong(turned(start, angle), points);
    return size.x() * size.y();
  };
  double best = 0.0, smallest = area(0.0), step = 0.5 * kPi / kAngles;
  const auto attempt = [&](double angle) {
    if (const double tried = area(angle); tried < smallest) best = angle, smallest = tried;
  };
  for (int i = 1; i < kAngles; ++i) attempt(i * step);
  for (int i = 0; i < kAngleHalvings; ++i) {
    step *= 0.5;
    attempt(best - step);
    attempt(best + step);
  }
  const Eigen::Matrix3d axes = turned(start, best);
  return {axes, sizeAlong(axes, points)};
}

double facingShare(const WeldedMesh& mesh, const Vector3d& normal) {
  double area = 0.0, facing = 0.0;
  for (const Triangle& t : mesh.triangles) {
    const Vector3d vector = areaVector(mesh.points, t);
    area += vector.norm();
    if (std::abs(vector.dot(normal)) > 0.5 * vector.norm()) facing += vector.norm();
  }
  return facing / area;
}

namespace {

/// Returns the part of a closed plate that faces along the normal, moved to the middle of the plate. Sets the
/// thickness (m) with which it has the plate's volume.
TriangleMesh middleOf(const TriangleMesh& mesh, const WeldedMesh& welded, const Vector3d& normal,
                      double& thickness) {
  const std::vector<Triangle> all = chosen(mesh.triangles, welded.keptTriangles);
  std::vector<Triangle> triangles;
  double area = 0.0;
  for (const Triangle& t : all) {
    const Vector3d vector = areaVector(mesh.positions, t);
    if (!(vector.normalized().dot(normal) > 0.5)) continue;
    triangles.push_back(t);
    area += vector.norm();
  }
  const double volume = signedVolume(mesh.positions, all);
  thickness = area > 0.0 ? std::abs(volume) / area : 0.0;
  TriangleMesh middle = partOf(mesh, std::move(triangles));
  for (Vector3d& p : middle.positions) p -= std::copysign(0.5 * thickness, volume) * normal;
  return middle;
}

double longestEdge(const TriangleMesh& mesh) {
  double longest = 0.0;
  for (const Edge& e : uniqueEdges(mesh.triangles))
    longest = std::max(longest, (mesh.positions[e[0]] - mesh.positions[e[1]]).norm());
  return longest;
}

/// Divides each triangle into four.
TriangleMesh divided(const TriangleMesh& mesh) {
  TriangleMesh finer = mesh;
  finer.normals.clear();
  finer.triangles.clear();
  std::map<Edge, std::uint32_t> middles;
  const auto middle = [&](std::uint32_t a, std::uint32_t b) {
    const auto [entry, isNew] = middles.try_emplace(edgeBetween(a, b), 0u);
    if (!isNew) return entry->second;
    entry->second = static_cast<std::uint32_t>(finer.positions.size());
    finer.positions.push_back(0.5 * (mesh.positions[a] + mesh.positions[b]));
    if (!mesh.uvs.empty()) finer.uvs.push_back(0.5f * (mesh.uvs[a] + mesh.uvs[b]));
    return entry->second;
  };
  for (const Triangle& t : mesh.triangles) {
    const std::uint32_t ab = middle(t[0], t[1]), bc = middle(t[1], t[2]), ca = middle(t[2], t[0]);
    for (const Triangle& part :
         {Triangle{t[0], ab, ca}, Triangle{ab, t[1], bc}, Triangle{ca, bc, t[2]}, Triangle{ab, bc, ca}})
      finer.triangles.push_back(part);
  }
  return finer;
}

/// Divides the triangles until the sheet can fold, but not beyond about half of the points it may have.
TriangleMesh refined(TriangleMesh mesh, std::size_t limit) {
  const double size = extent(mesh);
  while (longestEdge(mesh) > kSheetEdge * size && 4 * mesh.triangles.size() < limit) mesh = divided(mesh);
  return mesh;
}

/// Points with more neighbours are hubs of fans.
constexpr std::size_t kMostNeighbours = 32;

/// Adds the springs between second neighbours, which resist bending.
void addBendingSprings(SpringNetwork& sheet) {
  for (const Edge& pair : findTwoRingPairs(sheet, kMostNeighbours))
    sheet.springs.push_back({pair[0], pair[1], SpringKind::Brace, 1.0});
  std::sort(sheet.springs.begin(), sheet.springs.end(), isBefore);
}

/// Returns the mesh with its triangles turned so that neighbours have the same side.
TriangleMesh oriented(TriangleMesh mesh, const WeldedMesh& welded) {
  if (welded.report.inconsistentEdges == 0) return mesh;
  const std::vector<bool> turned = patchesFacingInward(welded.points, welded.triangles);
  for (std::size_t t = 0; t < turned.size(); ++t)
    if (Triangle& triangle = mesh.triangles[welded.keptTriangles[t]]; turned[t])
      std::swap(triangle[1], triangle[2]);
  return mesh;
}

SharedNetwork buildSheet(const TriangleMesh& anySides, double thickness, std::size_t points) {
  const Result<WeldedMesh> welded = weld(anySides);
  if (!welded || welded->report.components != 1) return nullptr;
  const TriangleMesh mesh = oriented(anySides, *welded);
  const std::size_t limit = points > 0 ? points : kSheetPoints;
  const Result<TriangleMesh> coarse = welded->points.size() > limit
                                          ? simplify(mesh, static_cast<std::uint32_t>(limit))
                                          : Result<TriangleMesh>(refined(mesh, limit));
  if (!coarse) return nullptr;
  NetworkSettings settings;
  settings.braces = BraceRule::None;
  settings.masses = MassRule::Area;
  const Result<SharedNetwork> network = buildNetwork(*coarse, settings);
  if (!network) return nullptr;
  auto cloth = std::make_shared<SpringNetwork>(**network);
  cloth->kind = NetworkKind::Cloth;
  addBendingSprings(*cloth);
  setSheetSprings(*cloth, kSheetBending);
  cloth->thickness = thickness;
  return cloth;
}

/// Returns whether an open mesh encloses what is below it, because its openings have no area: neighbouring
/// faces have other vertices on their common edge.
bool isClosedInEffect(const WeldedMesh& mesh) {
  constexpr std::size_t kSamples = 500;
  constexpr double kEnclosed = 0.9;  // winding number; below the rim of a bowl it is a half
  std::vector<Triangle> triangles = mesh.triangles;
  flip(triangles, patchesFacingInward(mesh.points, triangles));
  const TriangleBvh bvh(mesh.points, triangles);
  for (std::size_t i = 0; i < triangles.size(); i += 1 + triangles.size() / kSamples) {
    const Vector3d vector = areaVector(mesh.points, triangles[i]),
                   below = -1e-3 * std::sqrt(vector.norm()) * vector.normalized();
    if (bvh.windingNumber(centroid(mesh.points, triangles[i]) + below) < kEnclosed) return false;
  }
  return true;
}

}  // namespace

SharedNetwork sheetOf(const TriangleMesh& mesh, const WeldedMesh& welded, std::size_t points) {
  if (welded.report.components != 1) return nullptr;
  const FlatBox box = flatBoxOf(welded.points);
  const double size = box.size.head<2>().maxCoeff(), area = areaOf(welded.points, welded.triangles),
               border = borderLength(welded);
  const bool isFlat = box.size.z() < kFlat * size && facingShare(welded, box.axes.col(2)) > kPlateArea;
  const bool hasLongBorder = border * border > kSheetBorder * area;
  if (isFlat && !hasLongBorder) {  // a plate, closed but for some defects
    double thickness = 0.0;
    const TriangleMesh middle = middleOf(oriented(mesh, welded), welded, box.axes.col(2), thickness);
    return buildSheet(middle, thickness, points);
  }
  const bool isOpen = hasLongBorder && !isClosedInEffect(welded);
  return isFlat || isOpen ? buildSheet(mesh, kSheetThickness * size, points) : SharedNetwork();
}

// --- ropes -------------------------------------------------------------------------------------------------

namespace {

/// Length over diameter of a tube that becomes a rope, and its segments: as long as two diameters.
constexpr double kRopeLength = 25.0, kSegmentLength = 2.0;
constexpr std::uint32_t kMaxSegments = 200;

/// Largest distance of a section's places from its middle, in radii, besides half a segment: a bend or a
/// branch has more.
constexpr double kSectionRadii = 2.5;

std::uint32_t farthest(const std::vector<double>& length) {
  return static_cast<std::uint32_t>(std::max_element(length.begin(), length.end()) - length.begin());
}

/// Places on a tube, their distances (m) along it from one end, and the areas (m^2) for which they stand.
struct TubeSamples {
  std::vector<Vector3d> places;
  std::vector<double> along, area;

  void add(const Vector3d& place, double length, double weight) {
    places.push_back(place);
    along.push_back(length);
    area.push_back(weight);
  }
};

/// The smallest and the largest circumference of sections of the same mass, relative to the mean.
constexpr double kThinnest = 0.5, kThickest = 2.0;

/// Least mass of a section, relative to the mean: the lightest point limits the time step.
constexpr double kLeastMass = 0.2;

/// Samples the sections of a triangle at equal distances along the tube, each at both of its ends.
void sampleTriangle(const WeldedMesh& mesh, Triangle t, const std::vector<double>& length, double step,
                    TubeSamples& samples) {
  std::sort(t.begin(), t.end(), [&](std::uint32_t a, std::uint32_t b) { return length[a] < length[b]; });
  const Vector3d &low = mesh.points[t[0]], &middle = mesh.points[t[1]], &high = mesh.points[t[2]];
  const double from = length[t[0]], turn = length[t[1]], to = length[t[2]];
  const int pieces = 1 + static_cast<int>(std::min(1e4, (to - from) / step));
  const std::size_t first = samples.places.size();
  double widths = 0.0;
  for (int i = 0; i < pieces && from < to; ++i) {
    const double at = from + (i + 0.5) / pieces * (to - from);
    const Vector3d a = low + (at - from) / (to - from) * (high - low);
    const Vector3d b = at < turn ? Vector3d(low + (at - from) / (turn - from) * (middle - low))
                                 : Vector3d(high + (to - at) / (to - turn) * (middle - high));
    samples.add(a, at, (b - a).norm());
    samples.add(b, at, (b - a).norm());
    widths += 2.0 * (b - a).norm();
  }
  const double area = areaVector(low, middle, high).norm();
  for (std::size_t i = first; i < samples.area.size(); ++i)
    samples.area[i] = widths > 0.0 ? samples.area[i] * area / widths : 0.0;
}

/// Moves the first point of an axis to where the tube ends, in the direction in which the axis arrives.
void extendToEnd(Vector3d& end, const Vector3d& next, const Vector3d& afterNext, const TubeSamples& samples,
                 double reach) {
  const Vector3d outward = (next - afterNext).normalized();
  double farthest = 0.0;
  for (const Vector3d& place : samples.places)
    if ((place - end).norm() < reach) farthest = std::max(farthest, outward.dot(place - next));
  if (farthest > 0.0) end = next + farthest * outward;
}

/// Returns the middles of the sections at equal distances along the tube, and its ends; empty if a section is
/// not small and round enough. Sets the areas of the sections.
std::vector<Vector3d> findAxis(const TubeSamples& samples, double length, double radius,
                               std::uint32_t segments, std::vector<double>& area) {
  const double step = length / segments;
  std::vector<Vector3d> axis(segments + 1, Vector3d::Zero());
  area.assign(segments + 1, 0.0);
  const auto sectionOf = [&](std::size_t i) {
    return static_cast<std::size_t>(std::min(double(segments), std::round(samples.along[i] / step)));
  };
  for (std::size_t i = 0; i < samples.places.size(); ++i) {
    axis[sectionOf(i)] += samples.area[i] * samples.places[i];
    area[sectionOf(i)] += samples.area[i];
  }
  for (std::size_t s = 0; s < axis.size(); ++s) {
    if (area[s] == 0.0) return {};
    axis[s] /= area[s];
  }
  const double reach = kSectionRadii * radius + 0.5 * step;
  for (std::size_t i = 0; i < samples.places.size(); ++i)
    if ((samples.places[i] - axis[sectionOf(i)]).norm() > reach) return {};
  extendToEnd(axis[0], axis[1], axis[2], samples, reach);
  extendToEnd(axis[segments], axis[segments - 1], axis[segments - 2], samples, reach);
  return axis;
}

/// Sets the masses of a rope if its sections differ, as those of a cone: a section of a closed tube has the
/// mass of its volume, one of an open tube that of its area.
void setMasses(std::vector<double> area, bool isClosed, SpringNetwork& rope) {
  area.front() *= 2.0, area.back() *= 2.0;  // they are half as long
  const double mean = std::accumulate(area.begin(), area.end(), 0.0) / static_cast<double>(area.size());
  const auto isUsual = [&](double a) { return a > kThinnest * mean && a < kThickest * mean; };
  if (std::all_of(area.begin() + 1, area.end() - 1, isUsual)) return;
  std::vector<double>& masses = rope.massFractions;
  for (std::size_t s = 0; s < area.size(); ++s) masses[s] *= isClosed ? area[s] * area[s] : area[s];
  const auto sum = [&] { return std::accumulate(masses.begin(), masses.end(), 0.0); };
  const double least = kLeastMass * sum() / static_cast<double>(masses.size());
  for (double& mass : masses) mass = std::max(mass, least);
  const double all = sum();
  for (double& mass : masses) mass /= all;
}

/// Returns the radius of the round rope that has the volume of a closed tube, or the circumference of an open
/// one, whose radius is `radius`.
double roundRadius(const WeldedMesh& welded, const std::vector<Vector3d>& axis, double radius) {
  if (!welded.report.watertight()) return radius;
  double length = 0.0;
  for (std::size_t i = 1; i < axis.size(); ++i) length += (axis[i] - axis[i - 1]).norm();
  const double volume = std::abs(signedVolume(welded.points, welded.triangles));
  return std::sqrt(volume / (kPi * length));
}

}  // namespace

SharedNetwork ropeOf(const WeldedMesh& welded) {
  if (welded.report.components != 1) return nullptr;
  const Links links = edgeLinks(welded.points, uniqueEdges(welded.triangles));
  const std::uint32_t end = farthest(shortestPaths(links, welded.triangles[0][0], HUGE_VAL));
  const std::vector<double> length = shortestPaths(links, end, HUGE_VAL);
  const double total = length[farthest(length)],
               radius = areaOf(welded.points, welded.triangles) / (2.0 * kPi * total);
  if (!(total > 2.0 * kRopeLength * radius)) return nullptr;
  RopeSettings settings;
  settings.length = total;
  settings.segments = static_cast<std::uint32_t>(
      std::min(double(kMaxSegments), std::ceil(total / (2.0 * kSegmentLength * radius))));
  const double step = 0.5 * total / settings.segments;
  TubeSamples samples;
  for (const Triangle& t : welded.triangles) sampleTriangle(welded, t, length, step, samples);
  std::vector<double> area;
  const std::vector<Vector3d> axis = findAxis(samples, total, radius, settings.segments, area);
  if (axis.empty()) return nullptr;
  const Result<SharedNetwork> straight = buildRope(settings);
  if (!straight) return nullptr;
  auto rope = std::make_shared<SpringNetwork>(**straight);
  rope->restPoints = axis;
  setMasses(std::move(area), welded.report.watertight(), *rope);
  rope->thickness = 2.0 * roundRadius(welded, axis, radius);
  return rope;
}

}  // namespace limber
