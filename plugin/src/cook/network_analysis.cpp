// SPDX-License-Identifier: Zlib
#include <limber/network_analysis.h>

#include "cook/global_rigidity.h"
#include "cook/network_pieces.h"
#include "cook/network_remarks.h"
#include "cook/own_weight.h"
#include "cook/point_spread.h"
#include "cook/return_rate.h"
#include "cook/rigidity.h"
#include "cook/stiffness_matrix.h"
#include "cook/time_step.h"
#include "mesh/edges.h"
#include "mesh/surface.h"
#include "mesh/triangle_bvh.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

namespace limber {
namespace {

/// Of the size: how far a spring may leave the body and still be inside, the round-off of its surface.
constexpr double kMostOutside = 1e-6;

SoftBodySettings bodySettings(const AnalysisSettings& settings) {
  SoftBodySettings body;
  body.totalMass = settings.totalMass;
  body.extensionStiffness = body.compressionStiffness = settings.stiffness;
  body.damping = 0.0;
  return body;
}

/// What welding found, or, for surfaces that no welding has made, what can be seen of them.
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

/// As the volume term sees the surface, whichever way it faces.
void analyseInside(const SpringNetwork& network, NetworkAnalysis& a) {
  const std::vector<Triangle> outward = turnedOutward(network.restPoints, network.surface);
  a.volume = signedVolume(network.restPoints, outward);
  const TriangleBvh surface(network.restPoints, outward);
  const std::vector<Edge> edges = uniqueEdges(outward);
  const double tolerance = kMostOutside * extent(network.restPoints);
  a.springsOutside = static_cast<std::size_t>(
      std::count_if(network.springs.begin(), network.springs.end(), [&](const NetworkSpring& s) {
        if (std::binary_search(edges.begin(), edges.end(), Edge{s.a, s.b})) return false;
        return !surface.staysInside(network.restPoints[s.a], network.restPoints[s.b], tolerance);
      }));
}

/// Rigid motions of points within the plane or along the line in which they are judged.
std::size_t ownMotions(const std::vector<Eigen::Vector3d>& points, NetworkKind kind) {
  if (kind == NetworkKind::Rope) return 1;
  if (kind == NetworkKind::Cloth) return points.size() == 1 ? 2 : 3;
  return static_cast<std::size_t>(rigidMotions(points).cols());
}

/// Motions of the pieces against each other, which are no mechanisms of any of them.
std::size_t motionsBetween(const SpringNetwork& network, NetworkKind kind) {
  std::size_t motions = 0;
  for (const std::vector<Eigen::Index>& piece : findPieces(network)) {
    std::vector<Eigen::Vector3d> points;
    for (const Eigen::Index i : piece) points.push_back(network.restPoints[static_cast<std::size_t>(i)]);
    motions += ownMotions(points, kind);
  }
  return motions - std::min(motions, ownMotions(network.restPoints, kind));
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
  const std::size_t own = a.mechanisms - std::min(a.mechanisms, bendingMechanisms(a.kind, a.points));
  a.modeRatio = own == 0 && small.stiffest > 0.0 ? small.softest / small.stiffest : 0.0;
  a.rigidity = grade(own, a.modeRatio);
}

void analyseGlobalRigidity(const SpringNetwork& network, const Progress& goOn, NetworkAnalysis& a) {
  if (a.points > kMostForGlobalRigidity) return;
  const auto ask = [&](double done) { return goOn("global rigidity", done); };
  bool rigid = true;
  for (const std::vector<Eigen::Index>& piece : findPieces(network))
    rigid = rigid && isGloballyRigid(pieceOf(network, piece), 1, ask);
  a.globallyRigidKnown = !a.endedEarly;
  a.globallyRigid = a.globallyRigidKnown && rigid;
}

void analyseTimeSteps(const SpringNetwork& network, const AnalysisSettings& settings, NetworkAnalysis& a) {
  const TimeSteps steps = timeSteps(network, bodySettings(settings));
  a.criticalTimeStep = steps.critical;
  a.safeTimeStep = steps.safe;
}

void analyseLargeDeformations(const SpringNetwork& network, const AnalysisSettings& settings,
                              const Progress& goOn, NetworkAnalysis& a) {
  for (std::size_t kind = 0; kind < kDeformations && settings.runs > 0 && !a.endedEarly; ++kind) {
    const Progress ofAll = [&](const char* what, double done) {
      return goOn(what, (static_cast<double>(kind) + done) / kDeformations);
    };
    a.returns[kind] =
        measureReturns(network, static_cast<Deformation>(kind), settings.runs, settings.seed, ofAll);
  }
}

void analyseOwnWeight(const SpringNetwork& network, const AnalysisSettings& settings, const Progress& goOn,
                      NetworkAnalysis& a) {
  const std::optional<double> least = leastStiffness(network, bodySettings(settings), settings.gravity, goOn);
  a.leastStiffnessKnown = least.has_value();
  a.leastStiffness = least && std::isfinite(*least) ? *least : 0.0;
}

/// Asks the settings' progress whether to go on; once not, never again.
Progress asking(const AnalysisSettings& settings, bool& ended) {
  return [&](const char* what, double done) {
    ended = ended || (settings.progress && !settings.progress(what, done));
    return !ended;
  };
}

void analyseStages(const SpringNetwork& network, const AnalysisSettings& settings, NetworkAnalysis& a) {
  const Progress goOn = asking(settings, a.endedEarly);
  const bool solid = a.kind == NetworkKind::Solid;
  if (goOn("small deformations", 0.0)) analyseSmallDeformations(network, a);
  if (goOn("global rigidity", 0.0)) analyseGlobalRigidity(network, goOn, a);
  if (goOn("time steps", 0.0)) analyseTimeSteps(network, settings, a);
  if (solid && isClosed(network) && goOn("springs outside", 0.0)) analyseInside(network, a);
  if (solid && !a.endedEarly) analyseLargeDeformations(network, settings, goOn, a);
  if (solid && !a.endedEarly) analyseOwnWeight(network, settings, goOn, a);
}

}  // namespace

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
  a.kind = spreadOf(network.restPoints);
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

}  // namespace limber
