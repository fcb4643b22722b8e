// SPDX-License-Identifier: Zlib
#include <limber/network_analysis.h>

#include "cook/global_rigidity.h"
#include "cook/network_remarks.h"
#include "cook/own_weight.h"
#include "cook/point_spread.h"
#include "cook/return_rate.h"
#include "cook/rigidity.h"
#include "cook/time_step.h"
#include "cook/triangle_bvh.h"
#include "core/mesh_edges.h"
#include "core/surface_components.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>

namespace limber {
namespace {

/// Of the size: how far a spring may leave the body and still be inside, the round-off of its surface.
constexpr double kOutside = 1e-6;

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
  const EdgeDefects defects = findEdgeDefects(network.surface);
  report.vertices = report.points = network.restPoints.size();
  report.triangles = network.surface.size();
  report.components = findComponents(network.restPoints.size(), network.surface).count;
  report.openEdges = defects.open;
  report.nonManifoldEdges = defects.nonManifold;
  report.inconsistentEdges = defects.inconsistent;
  return report;
}

bool isClosed(const SpringNetwork& network) {
  if (network.surface.empty()) return false;
  const EdgeDefects defects = findEdgeDefects(network.surface);
  return defects.open + defects.nonManifold + defects.inconsistent == 0;
}

double enclosedBy(const SpringNetwork& network) {
  const Eigen::Vector3d origin = network.restPoints.front();
  double volume = 0.0;
  for (const Triangle& t : network.surface) {
    const Eigen::Vector3d a = network.restPoints[t[0]] - origin, b = network.restPoints[t[1]] - origin,
                          c = network.restPoints[t[2]] - origin;
    volume += a.dot(b.cross(c)) / 6.0;
  }
  return volume;
}

double sizeOf(const std::vector<Eigen::Vector3d>& points) {
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& p : points) box.extend(p);
  return box.sizes().maxCoeff();
}

std::size_t countOutside(const SpringNetwork& network) {
  const TriangleBvh surface(network.restPoints, network.surface);
  const std::vector<Edge> edges = uniqueEdges(network.surface);
  const double tolerance = kOutside * sizeOf(network.restPoints);
  return static_cast<std::size_t>(
      std::count_if(network.springs.begin(), network.springs.end(), [&](const NetworkSpring& s) {
        if (std::binary_search(edges.begin(), edges.end(), Edge{s.a, s.b})) return false;
        return !surface.staysInside(network.restPoints[s.a], network.restPoints[s.b], tolerance);
      }));
}

Rigidity grade(std::size_t mechanisms, double ratio) {
  if (mechanisms > 0) return Rigidity::Flexible;
  if (ratio < 1e-4) return Rigidity::NearlyFlexible;
  return ratio < 1e-3 ? Rigidity::Soft : Rigidity::Rigid;
}

void analyseSmallDeformations(const SpringNetwork& network, NetworkAnalysis& a) {
  const SmallDeformations small = smallDeformations(network);
  a.rank = small.rank;
  a.mechanisms = small.mechanisms;
  a.selfStresses = small.selfStresses;
  a.softestEigenvalue = small.softest;
  a.stiffestEigenvalue = small.stiffest;
  const std::size_t own = a.mechanisms - std::min(a.mechanisms, bendingMechanisms(a.kind, a.points));
  a.modeRatio = own == 0 && small.stiffest > 0.0 ? small.softest / small.stiffest : 0.0;
  a.rigidity = grade(own, a.modeRatio);
  a.globallyRigidKnown = a.points <= kMostForGlobalRigidity;
  a.globallyRigid = a.globallyRigidKnown && isGloballyRigid(network);
}

void analyseLargeDeformations(const SpringNetwork& network, const AnalysisSettings& settings,
                              NetworkAnalysis& a) {
  for (std::size_t kind = 0; kind < kDeformations && settings.runs > 0; ++kind) {
    const Progress ofAll = [&](const char* what, double done) {
      return !settings.progress ||
             settings.progress(what, (static_cast<double>(kind) + done) / kDeformations);
    };
    a.returns[kind] =
        measureReturns(network, static_cast<Deformation>(kind), settings.runs, settings.seed, ofAll);
  }
  const double least = leastStiffness(network, bodySettings(settings), settings.gravity);
  a.leastStiffness = std::isfinite(least) ? least : 0.0;
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
  a.mesh = meshReport(network);
  analyseSmallDeformations(network, a);
  const TimeSteps steps = timeSteps(network, bodySettings(settings));
  a.criticalTimeStep = steps.critical;
  a.safeTimeStep = steps.safe;
  if (a.kind == NetworkKind::Solid) {
    if (isClosed(network)) {
      a.volume = enclosedBy(network);
      a.springsOutside = countOutside(network);
    }
    analyseLargeDeformations(network, settings, a);
  }
  a.remarks = remarksOn(network, settings, a);
  return a;
}

}  // namespace limber
