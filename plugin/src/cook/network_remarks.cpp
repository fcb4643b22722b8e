// SPDX-License-Identifier: Zlib
#include "cook/network_remarks.h"

#include "cook/deformation_names.h"
#include "mesh/edges.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace limber {
namespace {

using Remarks = std::vector<std::string>;

constexpr double kGoodReturn = 0.99;    // below it a remark names the kinds that fail
constexpr double kUnevenMasses = 20.0;  // the lightest point's share over the mean sets the time step
constexpr double kShortSpring = 1e-3;   // of the mean length
constexpr char kTooFast[] = "its stiffest springs, or lightest points, take time steps too short for that";

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", value);
  return text;
}

void remarkOnMesh(const MeshReport& mesh, Remarks& remarks) {
  if (mesh.openEdges > 0)
    remarks.push_back("the surface is open (" + counted(mesh.openEdges, "edge has", "edges have") +
                      " one triangle only): its open part keeps no volume");
  if (mesh.nonManifoldEdges > 0)
    remarks.push_back(counted(mesh.nonManifoldEdges, "edge belongs", "edges belong") +
                      " to more than two triangles: inside and outside are undefined there");
  if (mesh.inconsistentEdges > 0)
    remarks.push_back(counted(mesh.inconsistentEdges, "edge lies", "edges lie") +
                      " between triangles that face opposite ways");
  if (mesh.degenerateTriangles + mesh.duplicateTriangles > 0)
    remarks.push_back(
        counted(mesh.degenerateTriangles + mesh.duplicateTriangles, "triangle was", "triangles were") +
        " dropped: without area, or there already");
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
  if (network.massShares.empty()) return;
  const auto [least, most] = std::minmax_element(network.massShares.begin(), network.massShares.end());
  if (*most > kUnevenMasses * *least)
    remarks.push_back("the heaviest point has " + number(*most / *least) +
                      " times the mass of the lightest: that makes time steps short");
}

void remarkOnBending(const SpringNetwork& network, const NetworkAnalysis& a, Remarks& remarks) {
  const bool line = a.kind == NetworkKind::Rope;
  const bool bends = std::any_of(network.springs.begin(), network.springs.end(),
                                 [](const NetworkSpring& s) { return s.kind == SpringKind::Bending; });
  const std::string where = line ? "all points are on a line" : "all points are in a plane";
  remarks.push_back(
      where + ": no springs resist bending at rest" +
      (bends ? ", its bending springs do once it is bent" : ", and it has no bending springs: it is limp"));
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
    remarks.push_back("its softest oscillation has only " + number(a.modeRatio) +
                      " of the stiffest one's eigenvalue: it wobbles like something with a hinge");
  if (a.globallyRigidKnown && !a.globallyRigid && a.mechanisms == 0)
    remarks.push_back("not globally rigid: other shapes than this one fit the same spring lengths");
  if (a.springsOutside > 0)
    remarks.push_back(counted(a.springsOutside, "spring leaves", "springs leave") +
                      " the body and ties parts together that only face each other");
}

void remarkOnReturns(const AnalysisSettings& settings, const NetworkAnalysis& a, Remarks& remarks) {
  if (settings.runs > 0 && a.returns[0].runs == 0)
    remarks.push_back(std::string("not let go from large deformations: ") + kTooFast);
  std::string failing;
  for (std::size_t kind = 0; kind < kDeformations; ++kind) {
    const ReturnRate& r = a.returns[kind];
    if (r.runs == 0 || r.rate() >= kGoodReturn) continue;
    failing += (failing.empty() ? "" : ", ") + std::string(kDeformationNames[kind]) + " " +
               std::to_string(r.returned) + " of " + std::to_string(r.runs);
  }
  if (!failing.empty()) remarks.push_back("does not always come back to its shape: " + failing);
}

void remarkOnWeight(const AnalysisSettings& settings, const NetworkAnalysis& a, Remarks& remarks) {
  if (!(settings.gravity > 0.0)) return;
  if (!a.leastStiffnessKnown)
    remarks.push_back(std::string("not known whether it carries its own weight: ") + kTooFast);
  else if (a.leastStiffness == 0.0)
    remarks.push_back("collapses under its own weight however stiff its springs are");
  else if (a.leastStiffness > settings.stiffness)
    remarks.push_back("collapses under its own weight of " + number(settings.totalMass) + " kg at " +
                      number(settings.stiffness) + " N/m: it needs " + number(a.leastStiffness) + " N/m");
}

}  // namespace

std::size_t bendingMechanisms(NetworkKind kind, std::size_t points) {
  if (points < 3 || kind == NetworkKind::Solid) return 0;
  return kind == NetworkKind::Rope ? 2 * points - 4 : points - 3;
}

std::vector<std::string> remarksOn(const SpringNetwork& network, const AnalysisSettings& settings,
                                   const NetworkAnalysis& analysis) {
  Remarks remarks;
  remarkOnMesh(analysis.mesh, remarks);
  remarkOnCrossings(analysis, remarks);
  if (analysis.pieces > 1)
    remarks.push_back(std::to_string(analysis.pieces) +
                      " pieces that no spring joins, each judged by itself");
  remarkOnSprings(network, remarks);
  if (analysis.endedEarly) {
    remarks.push_back("ended early: what had not been measured by then is missing");
    return remarks;
  }
  if (analysis.kind != NetworkKind::Solid) {
    remarkOnBending(network, analysis, remarks);
    return remarks;
  }
  remarkOnRigidity(analysis, remarks);
  remarkOnReturns(settings, analysis, remarks);
  remarkOnWeight(settings, analysis, remarks);
  return remarks;
}

}  // namespace limber
