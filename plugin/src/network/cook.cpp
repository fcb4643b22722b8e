// SPDX-License-Identifier: Zlib
// Makes soft bodies of any mesh: brings it to size, finds the form of each part, builds and skins it, and
// says what was chosen.

#include <limber/cook.h>

#include "mesh/surface.h"
#include "mesh/triangle_bvh.h"
#include "network/material.h"
#include "network/parts.h"
#include "network/tetrahedra.h"

#include <algorithm>
#include <cmath>

namespace limber {
namespace {

using Eigen::Vector3d;

// --- the mesh ----------------------------------------------------------------------------------------------

/// Sizes (m) that meshes keep, and the size of all others.
constexpr double kMinSize = 0.2, kMaxSize = 5.0, kUsualSize = 1.0;

std::string checkSettings(const CookSettings& s) {
  if (s.size && !(std::isfinite(*s.size) && *s.size > 0.0))
    return "size is " + inThreeDigits(*s.size) + " m, must be above 0";
  if (s.points != 0 && s.points < 8)
    return "points is " + std::to_string(s.points) + ", must be 8 or more, or 0";
  if (s.mode > CookMode::Braces) return "mode is none of the modes";
  if (s.skin && *s.skin > SkinKind::Barycentric) return "skin must be one of SkinKind's";
  if (s.pieces > PieceRule::Connected) return "pieces is no value of PieceRule";
  return checkWrapSettings(s.wrap, "wrap.");
}

double scaleOf(double extent, const CookSettings& settings) {
  if (settings.size) return *settings.size / extent;
  return extent >= kMinSize && extent <= kMaxSize ? 1.0 : kUsualSize / extent;
}

TriangleMesh resized(TriangleMesh mesh, double scale) {
  if (scale != 1.0)
    for (Vector3d& p : mesh.positions) p *= scale;
  return mesh;
}

/// Returns "1 200 vertices, 3 pieces, 24 open edges".
std::string describeDefects(const MeshReport& r) {
  std::string text =
      counted(r.vertices, "vertex", "vertices") + ", " + counted(r.components, "piece", "pieces");
  if (r.watertight()) return text + ", closed";
  if (r.openEdges > 0) text += ", " + counted(r.openEdges, "open edge", "open edges");
  if (r.nonManifoldEdges > 0)
    text += ", " + counted(r.nonManifoldEdges, "edge", "edges") + " of several sheets";
  if (r.inconsistentEdges > 0)
    text += ", " + counted(r.inconsistentEdges, "edge", "edges") + " of mixed orientation";
  return text;
}

std::string describeMesh(const MeshReport& report, double extent, double scale) {
  const std::string text = "mesh: " + describeDefects(report) + ", " + inThreeDigits(extent);
  if (scale == 1.0) return text + " m long";
  return text + " units long, made " + inThreeDigits(scale * extent) + " m long";
}

// --- solids ------------------------------------------------------------------------------------------------

/// Range of the number of points, and the least for small bodies.
constexpr double kMinPoints = 150.0, kMaxPoints = 400.0, kMinSmallPoints = 30.0;

/// Part of the surface that may be thinner than the thickness that matters.
constexpr double kThinShare = 0.1;

/// About as many triangles are sampled for the thickness.
constexpr std::size_t kThicknessSamples = 2000;

/// Thickness of thin parts, in spacings, so that the lattice can follow them, and the factor if it cannot: a
/// ball of 1.12 contains a site wherever it lies (covering radius sqrt(5)/4), but limbs of 1.12 fall apart.
constexpr double kLatticeThickness = 1.35, kThicker = 1.12;

/// Parts of the mesh farther than this from its filling, in spacings, are missed by it.
constexpr double kMissed = 0.75;

/// A closed surface that is to be filled.
struct Solid {
  WeldedMesh surface;
  double thickness = 0.0;  ///< m, of the thinnest part that matters
  double volume = 0.0;     ///< m^3
};

/// Returns the thickness (m) below which a tenth of the surface lies: the distance to the opposite side.
double thinPartThickness(const WeldedMesh& surface) {
  const TriangleBvh bvh(surface.points, surface.triangles);
  const double size = extent(surface.points);
  const std::size_t stride = 1 + surface.triangles.size() / kThicknessSamples;
  std::vector<std::pair<double, double>> samples;  // thickness and area
  double area = 0.0;
  for (std::size_t i = 0; i < surface.triangles.size(); i += stride) {
    const TriangleCorners t = cornersOf(surface.points, surface.triangles[i]);
    const Vector3d vector = areaVector(t);
    if (vector.norm() == 0.0) continue;
    const TriangleHit hit = bvh.firstHit(centroid(t), -vector.normalized(), 1e-4 * size, 2.0 * size);
    samples.push_back({hit ? hit.distance : size, vector.norm()});
    area += vector.norm();
  }
  std::sort(samples.begin(), samples.end());
  double sum = 0.0;
  for (const auto& [thickness, sampleArea] : samples)
    if ((sum += sampleArea) >= kThinShare * area) return thickness;
  return size;
}

Solid makeSolid(WeldedMesh surface) {
  surface.triangles = facingOutward(surface.points, std::move(surface.triangles));
  Solid solid{std::move(surface), 0.0, 0.0};
  solid.thickness = thinPartThickness(solid.surface);
  solid.volume = signedVolume(solid.surface.points, solid.surface.triangles);
  return solid;
}

/// A body-centred lattice has two points a cell, and about one more for the surface: 3 V / s^3. With a
/// spacing of the thickness, three points lie across it.
double spacingFor(const Solid& solid, double points) { return std::cbrt(3.0 * solid.volume / points); }

double wantedPoints(const Solid& solid) {
  return std::clamp(3.0 * solid.volume / std::pow(solid.thickness, 3.0), kMinPoints, kMaxPoints);
}

/// Returns the largest distance (m) of the mesh's points outside of the filling.
double largestMiss(const WeldedMesh& mesh, const TetrahedralMesh& filling) {
  const TriangleBvh bvh(filling.points, filling.surface);
  double largest = 0.0;
  for (const Vector3d& p : mesh.points) {
    const double distance = bvh.nearest(p).distance;
    if (distance > largest && !bvh.inside(p)) largest = distance;
  }
  return largest;
}

/// What was chosen for the bodies.
struct Choices {
  std::size_t points = 0, springs = 0, tetrahedra = 0, solids = 0, sheets = 0, ropes = 0, wrapped = 0,
              filled = 0, thickened = 0;
  double spacing = 0.0, thickness = 0.0;  ///< m, of the largest body
  double volume = 0.0, meshVolume = 0.0;  ///< m^3, of solids that differ from their closed meshes
};

struct Builder {
  const CookSettings& settings;
  Choices choices;
  bool going = true;
  double largest = 0.0;  ///< m, extent of the largest body

  bool report(const char* what, double done) {
    return going = going && (!settings.progress || settings.progress(what, done));
  }
};

/// Solids that touch in an edge or a point are apart when filled.
bool isConnected(const TetrahedralMesh& filling) {
  const std::vector<std::uint32_t> pieces = findPieces(filling.tetrahedra);
  return std::all_of(pieces.begin(), pieces.end(), [](std::uint32_t piece) { return piece == 0; });
}

bool isOneSolid(const MeshReport& report) { return report.watertight() && report.components == 1; }

/// Returns the closed surface of a part: the mesh itself, or a wrapped one if it is not one closed surface.
Result<Solid> solidOf(Builder& builder, const Part& part) {
  if (isOneSolid(part.welded.report)) return makeSolid(part.welded);
  ++builder.choices.wrapped;
  if (part.welded.report.openEdges > 0) ++builder.choices.filled;
  Result<WeldedMesh> surface = wrapOutside(part.mesh, builder.settings.wrap, 0.0);
  if (!surface) return Error{surface.error()};
  return makeSolid(std::move(*surface));
}

/// Returns the number of points of a part: smaller parts have fewer.
double pointsOf(const Builder& builder, const Part& part, const Solid& solid) {
  const double relativeSize = std::min(1.0, extent(part.welded.points) / builder.largest);
  const double wanted = builder.settings.points > 0 ? builder.settings.points : wantedPoints(solid);
  return std::max(std::min(wanted, kMinSmallPoints), relativeSize * wanted);
}

/// Largest number of spacings that are tried, and the ratios of points to the wanted number that end the
/// search.
constexpr int kThickTrials = 6;
constexpr double kTooMany = 1.2, kTooFew = 0.8;

/// Searches the spacing (m) at which a thickened body has the wanted number of points. Their number falls
/// with a power of the spacing, between that of solids and that of wires, which two trials tell.
struct SpacingSearch {
  double spacing, power = 2.5;
  double lastSpacing = 0.0, lastRatio = 0.0;

  /// `ratio`: of the points with the present spacing to the wanted number.
  void next(double ratio) {
    if (lastRatio > 0.0 && ratio != lastRatio)
      power = std::clamp(std::log(lastRatio / ratio) / std::log(spacing / lastSpacing), 0.8, 3.5);
    lastSpacing = std::exchange(spacing, spacing * std::pow(ratio, 1.0 / power));
    lastRatio = ratio;
  }
};

/// Returns about the spacing at which the solid has so many points when its thin parts are as thick as the
/// lattice needs them. A sheet of area A / 2 then has the volume A s kLatticeThickness / 2.
double thickSpacing(const Solid& solid, double points) {
  const double area = areaOf(solid.surface.points, solid.surface.triangles);
  return std::max(spacingFor(solid, points), std::sqrt(1.2 * kLatticeThickness * area / points));
}

/// Smallest spring constants of bodies, as fractions of Van Gelder's. Limbs of one tetrahedron across are not
/// exact anyway, so that they return from large deformations counts more.
constexpr double kExactGrowth = 0.2, kRobustGrowth = 0.5;

struct CookedFilling {
  TetrahedralMesh mesh;
  double spacing = 0.0;      ///< m
  bool isThickened = false;  ///< thin parts are thicker than in the mesh
  double minGrowth = kRobustGrowth;
};

/// Wraps a part so that nothing is thinner than the lattice, and fills it with about `points` points, which
/// then move towards the surface of the solid. The volume, and so the number of points, grows with the
/// thickness: the spacing is searched.
Result<CookedFilling> fillThickened(Builder& builder, const Part& part, const Solid& solid, double points) {
  Result<TetrahedralMesh> best = Error{};
  SpacingSearch search{thickSpacing(solid, points)};
  double thickness = kLatticeThickness, used = search.spacing, nearest = HUGE_VAL;
  for (int i = 0; i < kThickTrials; ++i) {
    if (!builder.report("tetrahedra", double(i) / kThickTrials)) return Error{kEnded};
    const double spacing = search.spacing;
    const Result<WeldedMesh> surface = wrapOutside(part.mesh, builder.settings.wrap, thickness * spacing);
    if (!surface) return Error{surface.error()};
    Result<TetrahedralMesh> filling = fillWithTetrahedra(*surface, spacing, &solid.surface);
    const bool isFilled = filling && isConnected(*filling);
    const double ratio = isFilled ? static_cast<double>(filling->points.size()) / points : HUGE_VAL;
    const double distance = std::abs(std::log(ratio));
    if (!best || distance < nearest) {
      best = std::move(filling);
      nearest = distance;
      used = spacing;
    }
    if (ratio > kTooFew && ratio < kTooMany) break;
    if (isFilled)
      search.next(ratio);
    else
      thickness *= kThicker;
  }
  if (!best) return Error{best.error()};
  return CookedFilling{std::move(*best), used, true, kRobustGrowth};
}

/// Largest ratio of points to the number that the user wants, and the ratio between two trials. Thickened
/// parts have more mass than those of the mesh, by two thirds for a star; more points only cost time.
constexpr double kMostExact = 1.5, kMorePoints = 1.15;

bool follows(const Part& part, const TetrahedralMesh& filling, double spacing) {
  return isConnected(filling) && largestMiss(part.welded, filling) < kMissed * spacing;
}

/// Returns the numbers of points, up to `most`, that are tried for a filling of about `points` points: if
/// these miss something, more; then fewer, if the user has chosen their number. Lattices of symmetric bodies
/// have few possible numbers of points.
std::vector<double> trialsOf(const Builder& builder, double points, double most) {
  std::vector<double> trials;
  for (double trial = points; trial <= most; trial *= kMorePoints) trials.push_back(trial);
  const double fewest = builder.settings.points > 0 ? points / kMostExact : points;
  for (double trial = points / kMorePoints; trial >= fewest; trial /= kMorePoints) trials.push_back(trial);
  return trials;
}

/// Fills a solid with about `points` points, at most `most`, so that `accepts(filling, spacing)` is true. Its
/// thin parts keep their thickness. The result is empty if there is no such filling, or if progress returns
/// false.
template <class Accept>
std::optional<CookedFilling> fillExactly(Builder& builder, const Solid& solid, double points, double most,
                                         Accept accepts) {
  for (const double trial : trialsOf(builder, points, most)) {
    const double spacing = spacingFor(solid, trial);
    if (solid.thickness < spacing) continue;
    Result<TetrahedralMesh> filling =
        fillWithPoints(solid.surface, static_cast<std::size_t>(std::max(8.0, trial)),
                       [&](double done) { return builder.report("tetrahedra", done); });
    if (!builder.going) return std::nullopt;
    if (!filling || static_cast<double>(filling->points.size()) > most) continue;
    const bool isThin = solid.thickness < kLatticeThickness * spacing;
    if (accepts(*filling, spacing))
      return CookedFilling{std::move(*filling), spacing, false, isThin ? kRobustGrowth : kExactGrowth};
  }
  return std::nullopt;
}

/// Largest height of a plate, as a fraction of its length, and the least share of its area that faces along
/// its normal: of round limbs it is 2/3.
constexpr double kPlateHeight = 0.15, kPlateShare = 0.72;

/// The factors by which a plate's height is stretched.
constexpr double kStretches[] = {1.0, 1.4, 2.0, 2.8, 4.0, 5.6};

/// Least share of a plate's volume that its tetrahedra fill: holes are as deep as it is.
constexpr double kLeastFilled = 0.95;

/// Fills a plate with tetrahedra as flat as itself if it is too thin for the lattice: it is turned so that
/// the lattice's axes are its own, stretched, filled, and brought back. Empty if the part is no plate, or as
/// fillExactly().
std::optional<CookedFilling> fillPlate(Builder& builder, const Part& part, const Solid& solid, double points,
                                       double most) {
  const FlatBox box = flatBoxOf(part.welded.points);
  if (box.size.z() > kPlateHeight * box.size.head<2>().maxCoeff()) return std::nullopt;
  if (facingShare(part.welded, box.axes.col(2)) < kPlateShare) return std::nullopt;
  for (const double factor : kStretches) {
    const Eigen::Matrix3d scale = Vector3d(1.0, 1.0, factor).asDiagonal();
    const Eigen::Matrix3d there = scale * box.axes.transpose(), back = box.axes * scale.inverse();
    WeldedMesh surface = solid.surface;
    for (Vector3d& p : surface.points) p = there * p;
    const Solid stretched = makeSolid(std::move(surface));
    std::optional<CookedFilling> filling =
        fillExactly(builder, stretched, points, most, [&](const TetrahedralMesh& f, double) {
          return isConnected(f) && signedVolume(f.points, f.surface) > kLeastFilled * stretched.volume;
        });
    if (!builder.going) return std::nullopt;
    if (!filling) continue;
    for (Vector3d& p : filling->mesh.points) p = back * p;
    filling->minGrowth = kExactGrowth;  // more would make them stiffer, and not return more often
    return filling;
  }
  return std::nullopt;
}

/// A thickened body that leaves out parts of the mesh as far as this fraction of its size, or has more than
/// so many times the volume of a closed one, has too few points.
constexpr double kMostMissed = 0.1, kMostGrown = 2.0;

/// The ratio between two numbers of points, if the user's number is too small.
constexpr double kEnough = 1.3;

bool hasTooFewPoints(const Part& part, const Solid& solid, const TetrahedralMesh& filling) {
  if (largestMiss(part.welded, filling) > kMostMissed * extent(part.welded.points)) return true;
  return std::abs(signedVolume(filling.points, filling.surface)) > kMostGrown * solid.volume;
}

/// The ratio of the points that are tried to those that Limber has chosen, if these are too few.
constexpr double kMostMore = 2.6;

/// A filling of many more points than wanted, as this multiple, is no substitute: it may take hours.
constexpr double kMostRough = 4.0;

/// Fills a part with tetrahedra. Where these would miss something, thin parts are thickened to what the
/// lattice can follow. If the points are too few, it takes more of them, up to kMinPoints where the user has
/// chosen their number, else up to kMostMore times as many.
Result<CookedFilling> fill(Builder& builder, const Part& part) {
  const Result<Solid> solid = solidOf(builder, part);
  if (!solid) return Error{solid.error()};
  const double points = pointsOf(builder, part, *solid);
  builder.choices.thickness = std::max(builder.choices.thickness, solid->thickness);
  const auto taken = [&](CookedFilling filling) {
    builder.choices.spacing = std::max(builder.choices.spacing, filling.spacing);
    if (filling.isThickened) ++builder.choices.thickened;
    return filling;
  };
  const auto follow = [&](const TetrahedralMesh& filling, double spacing) {
    return follows(part, filling, spacing);
  };
  // as many as are allowed if the user has not chosen their number
  const double allowed = builder.settings.points > 0 ? 0.0 : kMaxPoints / wantedPoints(*solid);
  Result<CookedFilling> thickened = Error{};
  const bool isChosen = builder.settings.points > 0;
  const double enough = isChosen ? kMinPoints : std::min(kMaxPoints, kMostMore * points);
  for (double trial = points;; trial = isChosen ? std::min(enough, kEnough * trial) : enough) {
    const double most = std::max(kMostExact, allowed) * trial;
    std::optional<CookedFilling> exact = fillPlate(builder, part, *solid, trial, most);
    if (!exact && builder.going) exact = fillExactly(builder, *solid, trial, most, follow);
    if (!builder.going) return Error{kEnded};
    if (exact) return taken(std::move(*exact));
    thickened = fillThickened(builder, part, *solid, trial);
    if (!builder.going) return Error{kEnded};
    if (trial >= enough) break;
    if (thickened && !hasTooFewPoints(part, *solid, thickened->mesh)) break;
  }
  if (thickened) return taken(std::move(*thickened));
  // one that misses something is better than none
  Result<TetrahedralMesh> rough = fillWithPoints(solid->surface, static_cast<std::size_t>(points));
  if (!rough || double(rough->points.size()) > kMostRough * points) return Error{thickened.error()};
  return taken({std::move(*rough), spacingFor(*solid, points), false, kRobustGrowth});
}

Result<SpringNetwork> fillWithSprings(Builder& builder, const Part& part) {
  Result<CookedFilling> filling = fill(builder, part);
  if (!filling) return Error{filling.error()};
  const auto goOn = [&](double done) { return builder.report("spring constants", done); };
  SpringNetwork network = materialNetwork(std::move(filling->mesh), goOn, filling->minGrowth);
  if (!builder.going) return Error{kEnded};
  return network;
}

/// Returns a coarse closed surface: the simplified mesh, or that of its filling if it is not one closed
/// surface.
Result<TriangleMesh> coarseSurface(Builder& builder, const Part& part) {
  if (!isOneSolid(part.welded.report)) {
    const Result<CookedFilling> filling = fill(builder, part);
    if (!filling) return Error{filling.error()};
    return meshOf(filling->mesh.points, filling->mesh.surface);
  }
  const Solid solid = makeSolid(part.welded);
  const double points = pointsOf(builder, part, solid);
  TriangleMesh mesh = meshOf(solid.surface.points, solid.surface.triangles);
  if (static_cast<double>(mesh.positions.size()) <= points) return mesh;
  return simplify(mesh, static_cast<std::uint32_t>(points));
}

/// Builds a coarse surface with braces inside.
Result<SpringNetwork> brace(Builder& builder, const Part& part) {
  const Result<TriangleMesh> coarse = coarseSurface(builder, part);
  if (!coarse) return Error{coarse.error()};
  NetworkSettings settings = builder.settings.network;
  settings.progress = [&builder, own = settings.progress](const char* what, double done) {
    return builder.report(what, done) && (!own || own(what, done));
  };
  const Result<SharedNetwork> network = buildNetwork(*coarse, settings);
  if (!network) return Error{network.error()};
  return **network;
}

// --- skins -------------------------------------------------------------------------------------------------

/// Meshes of more vertices get a sparse skin.
constexpr std::size_t kMaxDenseVertices = 5000;

SkinKind skinFor(const WeldedMesh& mesh, const CookSettings& settings) {
  if (settings.skin) return *settings.skin;
  return mesh.points.size() <= kMaxDenseVertices ? SkinKind::Dense : SkinKind::Sparse;
}

Result<SharedNetwork> cookSolid(Builder& builder, const Part& part) {
  const std::size_t thickened = builder.choices.thickened;
  Result<SpringNetwork> network =
      builder.settings.mode == CookMode::Braces ? brace(builder, part) : fillWithSprings(builder, part);
  if (!network) return Error{network.error()};
  network->report = part.welded.report;  // not that of the wrapped surface
  if (isOneSolid(part.welded.report) && builder.choices.thickened == thickened)
    network->volume = std::abs(signedVolume(part.welded.points, part.welded.triangles));
  if (!builder.report("skin", 0.0)) return Error{kEnded};
  SkinSettings skin;
  skin.kind = skinFor(part.welded, builder.settings);
  Result<SharedNetwork> skinned = withSkin(*network, part.mesh, skin);
  if (!skinned) return Error{skinned.error()};
  if (!builder.report("skin", 1.0)) return Error{kEnded};
  ++builder.choices.solids;
  if (network->volume == 0.0 && part.welded.report.watertight()) {
    builder.choices.volume += signedVolume((*skinned)->restPoints, (*skinned)->surface);
    builder.choices.meshVolume +=
        signedVolume(part.welded.points, facingOutward(part.welded.points, part.welded.triangles));
  }
  return skinned;
}

Result<SharedNetwork> cookPart(Builder& builder, const Part& part) {
  const std::size_t points = builder.settings.points > 0 ? builder.settings.points : std::size_t{0};
  if (SharedNetwork rope = ropeOf(part.welded)) {
    ++builder.choices.ropes;
    return rope;
  }
  if (SharedNetwork sheet = sheetOf(part.mesh, part.welded, points)) {
    ++builder.choices.sheets;
    return sheet;
  }
  return cookSolid(builder, part);
}

// --- the report --------------------------------------------------------------------------------------------

std::string centimetres(double metres) { return inThreeDigits(100.0 * metres) + " cm"; }

/// The report tells a volume that is this many times that of the mesh.
constexpr double kHeavier = 1.1;

std::string describeSolids(const Choices& c, const CookSettings& settings) {
  std::string text = counted(c.solids, "solid", "solids");
  if (settings.mode == CookMode::Braces)
    text += " with braces inside";
  else
    text += " filled with " + std::to_string(c.tetrahedra) + " tetrahedra, " + centimetres(c.spacing) +
            " apart for parts of " + centimetres(c.thickness);
  if (c.wrapped > 0) text += "; wrapped, because the mesh is not one closed surface";
  if (c.filled > 0) text += ", and its openings filled";
  if (c.thickened > 0) text += "; thin parts made as thick as the tetrahedra";
  if (c.volume > kHeavier * c.meshVolume && c.meshVolume > 0.0)
    text += "; " + inThreeDigits(c.volume / c.meshVolume) + " times the volume and the mass of the mesh";
  return text;
}

std::string describeBodies(const Choices& c, std::size_t pieces, const CookSettings& settings) {
  std::string text =
      "body: " + std::to_string(c.points) + " points, " + std::to_string(c.springs) + " springs";
  const std::size_t bodies = c.solids + c.sheets + c.ropes;
  if (bodies < pieces)
    text += ", " + counted(pieces, "piece", "pieces") + " in " + counted(bodies, "body", "bodies");
  if (c.solids > 0) text += ", " + describeSolids(c, settings);
  if (c.sheets > 0)
    text += ", " + counted(c.sheets, "sheet", "sheets") + " as cloth, because they are flat or open";
  if (c.ropes > 0) text += ", " + counted(c.ropes, "thin tube", "thin tubes") + " as rope";
  return text;
}

std::string describeDrawing(const std::vector<SharedNetwork>& bodies, const std::vector<Part>& parts,
                            const CookSettings& settings) {
  static constexpr const char* kHow[] = {// the skins in the order of SkinKind
                                         " vertices by dense skins (up to 5000 a body)",
                                         " vertices by sparse skins", " vertices by barycentric skins",
                                         " points by themselves"};
  std::array<std::size_t, 4> counts{};
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    if (bodies[i]->render.skin.size() == 0)
      counts[3] += bodies[i]->restPoints.size();
    else
      counts[std::size_t(skinFor(parts[i].welded, settings))] += parts[i].welded.points.size();
  }
  std::string text = "drawing:";
  for (std::size_t i = 0; i < counts.size(); ++i)
    if (counts[i] > 0) text += (text.back() == ':' ? " " : ", ") + std::to_string(counts[i]) + kHow[i];
  return text;
}

void count(Choices& c, const SpringNetwork& network) {
  c.points += network.restPoints.size();
  c.springs += network.springs.size();
  c.tetrahedra += network.tetrahedra.size();
}

}  // namespace

Result<CookedMesh> cook(const TriangleMesh& input, const CookSettings& settings) {
  if (std::string reason = checkSettings(settings); !reason.empty()) return Error{std::move(reason)};
  const Result<WeldedMesh> welded = weld(input);
  if (!welded) return Error{welded.error()};
  const double size = extent(welded->points);
  CookedMesh cooked;
  cooked.scale = scaleOf(size, settings);
  cooked.report[0] = describeMesh(welded->report, size, cooked.scale);
  Builder builder{settings, {}};
  if (!builder.report("pieces", 0.0)) return Error{kEnded};
  const bool mayBeApart = settings.pieces == PieceRule::Separate;
  const Result<std::vector<Part>> parts =
      splitIntoParts(resized(input, cooked.scale), settings.wrap, mayBeApart);
  if (!parts) return Error{parts.error()};
  if (!builder.report("pieces", 1.0)) return Error{kEnded};
  for (const Part& part : *parts) builder.largest = std::max(builder.largest, extent(part.welded.points));
  for (const Part& part : *parts) {
    Result<SharedNetwork> body = cookPart(builder, part);
    if (!body) return Error{body.error()};
    count(builder.choices, **body);
    cooked.bodies.push_back(std::move(*body));
  }
  cooked.report[1] = describeBodies(builder.choices, welded->report.components, settings);
  cooked.report[2] = describeDrawing(cooked.bodies, *parts, settings);
  return cooked;
}

}  // namespace limber
