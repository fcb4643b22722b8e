// SPDX-License-Identifier: Zlib
// Analyses a network before it is used: collects the measurements of the other files of this folder, adds
// remarks on unusual results and describes all of it in text.

#include "analysis/analysis.h"

#include "mesh/surface.h"
#include "mesh/triangle_bvh.h"
#include "network/stability.h"

#include <algorithm>
#include <cmath>
#include <cstdarg>
#include <cstdio>

namespace limber {
namespace {

constexpr double kThinSpread = 1e-4;

/// Returns Rope for points on a line, Cloth for points in a plane, else Solid. The tolerance is 1e-4 of their
/// largest distance from the centre.
NetworkKind kindOf(const std::vector<Eigen::Vector3d>& points) {
  if (points.size() < 3) return NetworkKind::Rope;
  const Spread s = principalSpread(points);
  const Eigen::Vector3d extents = (s.axes.transpose() * s.offsets).cwiseAbs().rowwise().maxCoeff();
  const double maxThickness = kThinSpread * s.offsets.colwise().norm().maxCoeff();
  if (extents[1] <= maxThickness) return NetworkKind::Rope;
  return extents[0] <= maxThickness ? NetworkKind::Cloth : NetworkKind::Solid;
}

/// Returns the points moved into their plane (Cloth) or onto their line (Rope). Otherwise distances below the
/// tolerance of kindOf() would resist bending, by their square, like a stiffness of the body.
std::vector<Eigen::Vector3d> flattened(std::vector<Eigen::Vector3d> points, NetworkKind kind) {
  if (points.empty() || kind == NetworkKind::Solid) return points;
  const Spread s = principalSpread(points);
  const Eigen::Index thinAxes = kind == NetworkKind::Rope ? 2 : 1;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector3d offset = s.size * s.offsets.col(static_cast<Eigen::Index>(i));
    for (Eigen::Index k = 0; k < thinAxes; ++k) points[i] -= s.axes.col(k).dot(offset) * s.axes.col(k);
  }
  return points;
}

/// Fraction of the size by which a spring inside the body may leave it: the round-off of its surface.
constexpr double kMaxOutside = 1e-6;

SoftBodySettings bodySettings(const AnalysisSettings& settings) {
  SoftBodySettings body;
  body.totalMass = settings.totalMass;
  body.extensionStiffness = body.compressionStiffness = settings.stiffness;
  body.damping = 0.0;
  return body;
}

/// Returns the report of welding. For surfaces that were not welded, counts what the surface itself shows.
MeshReport meshReport(const SpringNetwork& network) {
  MeshReport report = network.report;
  if (report.triangles > 0 || network.surface.empty()) return report;
  report.vertices = report.points = network.restPoints.size();
  report.triangles = network.surface.size();
  report.components = findComponents(network.restPoints.size(), network.surface).count;
  setEdgeDefects(report, network.surface);
  return report;
}

bool isClosed(const SpringNetwork& network) {
  return !network.surface.empty() && findEdgeDefects(network.surface).none();
}

/// Measures the inside with the orientation that the volume term uses, whether the surface faces inward or
/// outward.
void analyseInside(const SpringNetwork& network, NetworkAnalysis& a) {
  const std::vector<Triangle> outward = facingOutward(network.restPoints, network.surface);
  a.volume = signedVolume(network.restPoints, outward);
  const TriangleBvh surface(network.restPoints, outward);
  const std::vector<Edge> edges = uniqueEdges(outward);
  const double tolerance = kMaxOutside * extent(network.restPoints);
  a.springsOutside = static_cast<std::size_t>(
      std::count_if(network.springs.begin(), network.springs.end(), [&](const NetworkSpring& s) {
        if (std::binary_search(edges.begin(), edges.end(), Edge{s.a, s.b})) return false;
        return !surface.staysInside(network.restPoints[s.a], network.restPoints[s.b], tolerance);
      }));
}

/// Counts the rigid motions of points within their plane or along their line.
std::size_t rigidMotionCount(const std::vector<Eigen::Vector3d>& points, NetworkKind kind) {
  if (kind == NetworkKind::Rope) return 1;
  if (kind == NetworkKind::Cloth) return points.size() == 1 ? 2 : 3;
  return static_cast<std::size_t>(rigidMotions(points).cols());
}

/// Counts the motions of the pieces against each other. They are not mechanisms of any piece.
std::size_t motionsBetween(const SpringNetwork& network, NetworkKind kind) {
  std::size_t motions = 0;
  for (const std::vector<std::uint32_t>& piece : findPieces(network))
    motions += rigidMotionCount(chosen(network.restPoints, piece), kind);
  return motions - std::min(motions, rigidMotionCount(network.restPoints, kind));
}

/// Counts the mechanisms that every body in a plane (#points - 3 out of it) or on a line (2 #points - 4
/// across it) has with any number of springs: to first order nothing resists bending. 0 for solids.
std::size_t bendingMechanisms(NetworkKind kind, std::size_t points) {
  if (points < 3 || kind == NetworkKind::Solid) return 0;
  return kind == NetworkKind::Rope ? 2 * points - 4 : points - 3;
}

Rigidity grade(std::size_t mechanisms, double ratio) {
  if (mechanisms > 0) return Rigidity::Flexible;
  if (ratio < 1e-4) return Rigidity::NearlyFlexible;
  return ratio < 1e-3 ? Rigidity::Soft : Rigidity::Rigid;
}

void analyseSmallDeformations(SpringNetwork network, NetworkAnalysis& a) {
  network.restPoints = flattened(std::move(network.restPoints), a.kind);
  const SmallDeformations small = smallDeformations(network);
  a.rank = small.rank;
  a.mechanisms = small.mechanisms - std::min(small.mechanisms, motionsBetween(network, a.kind));
  a.selfStresses = small.selfStresses;
  a.softestEigenvalue = small.softest;
  a.stiffestEigenvalue = small.stiffest;
  const std::size_t nonBending = a.mechanisms - std::min(a.mechanisms, bendingMechanisms(a.kind, a.points));
  a.modeRatio = nonBending == 0 && small.stiffest > 0.0 ? small.softest / small.stiffest : 0.0;
  a.rigidity = grade(nonBending, a.modeRatio);
}

void analyseGlobalRigidity(const SpringNetwork& network, const Progress& goOn, NetworkAnalysis& a) {
  if (a.points > kMaxForGlobalRigidity) return;
  const auto keepGoing = [&](double done) { return goOn("global rigidity", done); };
  bool rigid = true;
  for (const std::vector<std::uint32_t>& piece : findPieces(network))
    rigid = rigid && isGloballyRigid(pieceOf(network, piece), 1, keepGoing);
  a.globallyRigidKnown = !a.endedEarly;
  a.globallyRigid = a.globallyRigidKnown && rigid;
}

void analyseLargeDeformations(const SpringNetwork& network, const AnalysisSettings& settings,
                              const Progress& goOn, NetworkAnalysis& a) {
  for (std::size_t kind = 0; kind < kDeformations && settings.runs > 0 && !a.endedEarly; ++kind) {
    const Progress overallProgress = [&](const char* what, double done) {
      return goOn(what, (static_cast<double>(kind) + done) / kDeformations);
    };
    a.returns[kind] = measureReturns(network, static_cast<Deformation>(kind), settings.runs, settings.seed,
                                     overallProgress, settings.parallel);
  }
}

/// Returns the settings' progress function. Once it has returned false, it always returns false.
Progress stickyProgress(const AnalysisSettings& settings, bool& ended) {
  return [&](const char* what, double done) {
    ended = ended || (settings.progress && !settings.progress(what, done));
    return !ended;
  };
}

void analyseStages(const SpringNetwork& network, const AnalysisSettings& settings, NetworkAnalysis& a) {
  const Progress goOn = stickyProgress(settings, a.endedEarly);
  if (goOn("small deformations", 0.0)) analyseSmallDeformations(network, a);
  if (goOn("global rigidity", 0.0)) analyseGlobalRigidity(network, goOn, a);
  if (goOn("time steps", 0.0)) {
    const TimeSteps steps = timeSteps(network, bodySettings(settings));
    a.criticalTimeStep = steps.critical;
    a.safeTimeStep = steps.safe;
  }
  if (!a.folds && isClosed(network) && goOn("springs outside", 0.0)) analyseInside(network, a);
  if (!a.folds && !a.endedEarly) analyseLargeDeformations(network, settings, goOn, a);
  if (!a.folds && !a.endedEarly)
    a.standingStiffness = standingStiffness(network, bodySettings(settings), settings.gravity, goOn);
}

/// In the order of Deformation.
constexpr std::array<const char*, kDeformations> kDeformationNames{"squash", "twist",   "noise",    "push",
                                                                   "mirror", "flatten", "inversion"};

using Remarks = std::vector<std::string>;

constexpr double kGoodReturn = 0.99;    // below it a remark names the kinds that fail
constexpr double kUnevenMasses = 20.0;  // heaviest over lightest; the lightest point sets the time step
constexpr double kShortSpring = 1e-3;   // of the mean length
constexpr char kTooFast[] = "its stiffest springs, or lightest points, take time steps too short for that";

void remarkOnMesh(const MeshReport& mesh, Remarks& remarks) {
  if (mesh.openEdges > 0)
    remarks.push_back("the surface is open (" + counted(mesh.openEdges, "edge has", "edges have") +
                      " one triangle only): its open part keeps no volume");
  if (mesh.nonManifoldEdges > 0)
    remarks.push_back(counted(mesh.nonManifoldEdges, "edge belongs", "edges belong") +
                      " to more than two triangles: inside and outside are undefined there");
  if (mesh.inconsistentEdges > 0)
    remarks.push_back(counted(mesh.inconsistentEdges, "edge lies", "edges lie") +
                      " between triangles that face opposite directions");
  if (mesh.degenerateTriangles + mesh.duplicateTriangles > 0)
    remarks.push_back(
        counted(mesh.degenerateTriangles + mesh.duplicateTriangles, "triangle was", "triangles were") +
        " dropped: without area, or duplicates");
}

void remarkOnCrossings(const NetworkAnalysis& a, Remarks& remarks) {
  if (a.piercingEdges == 0) return;
  remarks.push_back(
      counted(a.piercingEdges, "edge passes", "edges pass") +
      " through a triangle: where parts of the surface overlap, inside and outside are mixed, and "
      "the volume counts twice");
}

void remarkOnSprings(const SpringNetwork& network, Remarks& remarks) {
  double sum = 0.0, shortest = HUGE_VAL;
  for (const NetworkSpring& s : network.springs) {
    const double length = (network.restPoints[s.b] - network.restPoints[s.a]).norm();
    sum += length;
    shortest = std::min(shortest, length);
  }
  if (!network.springs.empty() && shortest * static_cast<double>(network.springs.size()) < kShortSpring * sum)
    remarks.push_back("some springs are shorter than a thousandth of the mean: weld with a tolerance");
  if (network.massFractions.empty()) return;
  const auto [lightest, heaviest] =
      std::minmax_element(network.massFractions.begin(), network.massFractions.end());
  if (*heaviest > kUnevenMasses * *lightest)
    remarks.push_back("the heaviest point has " + inThreeDigits(*heaviest / *lightest) +
                      " times the mass of the lightest: that makes time steps short");
}

void remarkOnBending(const SpringNetwork& network, const NetworkAnalysis& a, Remarks& remarks) {
  const bool line = a.kind == NetworkKind::Rope;
  const bool bends = std::any_of(network.springs.begin(), network.springs.end(),
                                 [](const NetworkSpring& s) { return s.kind == SpringKind::Bending; });
  const std::string where = line ? "all points are on a line" : "all points are in a plane";
  remarks.push_back(where + ": no springs resist bending at rest" +
                    (bends ? ", its bending springs resist once it is bent"
                           : ", and it has no bending springs, so it folds freely"));
  const std::size_t unavoidable = bendingMechanisms(a.kind, a.points);
  if (a.mechanisms > unavoidable)
    remarks.push_back(counted(a.mechanisms - unavoidable, "mechanism", "mechanisms") +
                      (line ? " along the line" : " within the plane") + " besides bending");
}

void remarkOnRigidity(const NetworkAnalysis& a, Remarks& remarks) {
  if (a.mechanisms > 0)
    remarks.push_back(counted(a.mechanisms, "deformation stretches", "deformations stretch") +
                      " no spring: points within flat faces and points with fewer than three springs that "
                      "span space move freely; braces help");
  else if (a.rigidity == Rigidity::NearlyFlexible)
    remarks.push_back("its softest oscillation has only " + inThreeDigits(a.modeRatio) +
                      " of the stiffest one's eigenvalue: it moves nearly freely, as with a hinge");
  if (a.globallyRigidKnown && !a.globallyRigid && a.mechanisms == 0)
    remarks.push_back("not globally rigid: other shapes than this one fit the same spring lengths");
  if (a.springsOutside > 0)
    remarks.push_back(counted(a.springsOutside, "spring leaves", "springs leave") +
                      " the body, between parts that only face each other");
}

void remarkOnReturns(const AnalysisSettings& settings, const NetworkAnalysis& a, Remarks& remarks) {
  if (settings.runs > 0 && a.returns[0].runs == 0)
    remarks.push_back(std::string("large deformations were not tested: ") + kTooFast);
  std::string failing;
  for (std::size_t kind = 0; kind < kDeformations; ++kind) {
    const ReturnRate& r = a.returns[kind];
    if (r.runs == 0 || r.rate() >= kGoodReturn) continue;
    failing += (failing.empty() ? "" : ", ") + std::string(kDeformationNames[kind]) + " " +
               std::to_string(r.returned) + " of " + std::to_string(r.runs);
  }
  if (!failing.empty()) remarks.push_back("does not always return to its shape: " + failing);
}

void remarkOnWeight(const AnalysisSettings& settings, const NetworkAnalysis& a, Remarks& remarks) {
  if (!(settings.gravity > 0.0)) return;
  if (!a.standingStiffness)
    remarks.push_back(std::string("not known whether it carries its own weight: ") + kTooFast);
  else if (std::isinf(*a.standingStiffness))
    remarks.push_back("does not stand under its own weight however stiff its springs are");
  else if (*a.standingStiffness > settings.stiffness)
    remarks.push_back("sinks below 90 % of its height under its own weight of " +
                      inThreeDigits(settings.totalMass) + " kg at " + inThreeDigits(settings.stiffness) +
                      " N/m: to stand it needs " + inThreeDigits(*a.standingStiffness) + " N/m");
}

/// Returns remarks on unusual properties of the network and how to repair them.
std::vector<std::string> remarksOn(const SpringNetwork& network, const AnalysisSettings& settings,
                                   const NetworkAnalysis& analysis) {
  Remarks remarks;
  remarkOnMesh(analysis.mesh, remarks);
  remarkOnCrossings(analysis, remarks);
  if (analysis.pieces > 1)
    remarks.push_back(std::to_string(analysis.pieces) +
                      " pieces that no spring joins; each is analysed by itself");
  remarkOnSprings(network, remarks);
  if (analysis.endedEarly) {
    remarks.push_back("ended early: some results are missing");
    return remarks;
  }
  if (analysis.kind != NetworkKind::Solid) remarkOnBending(network, analysis, remarks);
  if (analysis.folds) return remarks;
  remarkOnRigidity(analysis, remarks);
  remarkOnReturns(settings, analysis, remarks);
  remarkOnWeight(settings, analysis, remarks);
  return remarks;
}

}  // namespace

std::size_t countPiercingEdges(const std::vector<Eigen::Vector3d>& points,
                               const std::vector<Triangle>& triangles) {
  const TriangleBvh surface(points, triangles);
  const std::vector<Edge> edges = uniqueEdges(triangles);
  const auto pierces = [&](const Edge& edge) {
    const auto sharesNoPoint = [&](std::uint32_t triangle) {
      const Triangle& t = triangles[triangle];
      return std::none_of(t.begin(), t.end(), [&](std::uint32_t i) { return i == edge[0] || i == edge[1]; });
    };
    return surface.isPierced(points[edge[0]], points[edge[1]], sharesNoPoint);
  };
  return static_cast<std::size_t>(std::count_if(edges.begin(), edges.end(), pierces));
}

double ReturnRate::standardError() const {
  return runs ? std::sqrt(rate() * (1.0 - rate()) / static_cast<double>(runs)) : 0.0;
}

ReturnRate NetworkAnalysis::allReturns() const {
  ReturnRate all;
  for (const Deformation deformation : {Deformation::Squash, Deformation::Twist, Deformation::Noise,
                                        Deformation::Push, Deformation::Mirror}) {
    const ReturnRate& one = returns[static_cast<std::size_t>(deformation)];
    all.runs += one.runs;
    all.returned += one.returned;
    all.mirrored += one.mirrored;
  }
  return all;
}

NetworkAnalysis analyse(const SpringNetwork& network, const AnalysisSettings& settings) {
  NetworkAnalysis a;
  a.kind = kindOf(network.restPoints);
  a.folds = a.kind != NetworkKind::Solid || network.kind != NetworkKind::Solid;
  a.points = network.restPoints.size();
  a.springs = network.springs.size();
  a.braces = static_cast<std::size_t>(
      std::count_if(network.springs.begin(), network.springs.end(),
                    [](const NetworkSpring& s) { return s.kind == SpringKind::Brace; }));
  a.pieces = findPieces(network).size();
  a.mesh = meshReport(network);
  a.piercingEdges = countPiercingEdges(network.restPoints, network.surface);
  analyseStages(network, settings, a);
  a.remarks = remarksOn(network, settings, a);
  return a;
}

namespace {

/// Formats numbers and short words like printf.
#if defined(__GNUC__)
__attribute__((format(printf, 1, 2)))
#endif
std::string
line(const char* format, ...) {
  char text[200];
  va_list values;
  va_start(values, format);
  std::vsnprintf(text, sizeof text, format, values);
  va_end(values);
  return std::string(text) + "\n";
}

// in the order of the enumerations
constexpr std::array<const char*, 3> kKindNames{"on a line", "flat", "solid"};
constexpr char kCurved[] = "curved";  // a rope or cloth that is neither
constexpr std::array<const char*, 4> kRigidityNames{"flexible", "nearly flexible", "soft", "rigid"};

const char* globalRigidity(const NetworkAnalysis& a) {
  if (a.globallyRigidKnown) return a.globallyRigid ? "yes" : "no";
  return a.endedEarly ? "not tested" : "not tested: too many points";
}

std::string returnLines(const NetworkAnalysis& a) {
  const ReturnRate all = a.allReturns();
  if (all.runs == 0) return {};
  std::string text = line("returns             %.1f %% +- %.1f of %u runs, %u more as its mirror image",
                          100.0 * all.rate(), 100.0 * all.standardError(), all.runs, all.mirrored);
  for (std::size_t kind = 0; kind < kDeformations; ++kind)
    text += line("  %-17s %u of %u", kDeformationNames[kind], a.returns[kind].returned, a.returns[kind].runs);
  return text;
}

}  // namespace

std::string describe(const NetworkAnalysis& a) {
  const bool isCurved = a.folds && a.kind == NetworkKind::Solid;
  std::string text =
      line("%s: %zu points, %zu springs, %zu of them braces",
           isCurved ? kCurved : kKindNames[static_cast<std::size_t>(a.kind)], a.points, a.springs, a.braces);
  if (a.mesh.triangles > 0) text += describe(a.mesh) + "\n";
  if (a.volume > 0.0) text += line("volume              %.4g m^3", a.volume);
  text += line("rigidity            %s: rank %zu, %zu mechanisms, %zu self-stresses",
               kRigidityNames[static_cast<std::size_t>(a.rigidity)], a.rank, a.mechanisms, a.selfStresses);
  text +=
      line("softest : stiffest  %.3g : %.3g = %.2g", a.softestEigenvalue, a.stiffestEigenvalue, a.modeRatio);
  text += line("globally rigid      %s", globalRigidity(a));
  text += returnLines(a);
  if (a.standingStiffness && *a.standingStiffness > 0.0 && std::isfinite(*a.standingStiffness))
    text += line("own weight          stands at 90 %% of its height with springs of %.3g N/m",
                 *a.standingStiffness);
  text += line("time step           %.3g s critical, %.3g s safe", a.criticalTimeStep, a.safeTimeStep);
  if (a.volume > 0.0) text += line("springs outside     %zu", a.springsOutside);
  for (const std::string& remark : a.remarks) text += "! " + remark + "\n";
  return text;
}

}  // namespace limber
