// SPDX-License-Identifier: Zlib
#include "cook/cook_names.h"
#include "cook/cook_report.h"

#include <nlohmann/json.hpp>

namespace limber::demo {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kSchemaVersion = 1;

Json springsJson(const SpringNetwork& network) {
  const auto counts = springCounts(network);
  Json json = {{"count", network.springs.size()}};
  for (std::size_t kind = 0; kind < counts.size(); ++kind) json[kSpringKinds.names[kind]] = counts[kind];
  return json;
}

Json skinJson(const Skin& skin) {
  if (skin.size() == 0) return nullptr;
  return {{"places", skin.size()}, {"weights", skin.weights.size()}};
}

Json networkJson(const CookReport& r) {
  const SpringNetwork& network = *r.network;
  return {{"kind", kNetworkKinds[network.kind]},
          {"points", network.restPoints.size()},
          {"springs", springsJson(network)},
          {"bracesPerPoint", bracesPerPoint(r.analysis)},
          {"surfaceTriangles", network.surface.size()},
          {"tetrahedra", network.tetrahedra.size()},
          {"stiffnessPerModulus", network.stiffnessPerModulus},
          {"renderVertices", network.render.vertexToPoint.size()},
          {"renderTriangles", network.render.triangles.size()},
          {"skin", skinJson(network.render.skin)}};
}

Json meshJson(const MeshReport& m) {
  if (m.vertices == 0) return nullptr;
  return {{"vertices", m.vertices},
          {"points", m.points},
          {"triangles", m.triangles},
          {"degenerateTriangles", m.degenerateTriangles},
          {"duplicateTriangles", m.duplicateTriangles},
          {"isolatedVertices", m.isolatedVertices},
          {"components", m.components},
          {"openEdges", m.openEdges},
          {"nonManifoldEdges", m.nonManifoldEdges},
          {"inconsistentEdges", m.inconsistentEdges},
          {"watertight", m.watertight()}};
}

Json returnJson(const ReturnRate& r) {
  if (r.runs == 0) return nullptr;
  return {{"runs", r.runs},
          {"returned", r.returned},
          {"mirrored", r.mirrored},
          {"rate", r.rate()},
          {"standardError", r.standardError()}};
}

Json returnsJson(const NetworkAnalysis& a) {
  Json json = {{"all", returnJson(a.allReturns())}};
  for (std::size_t kind = 0; kind < kDeformations; ++kind)
    json[kDeformationNames.names[kind]] = returnJson(a.returns[kind]);
  return json;
}

Json analysisJson(const NetworkAnalysis& a) {
  return {{"shape", kNetworkKinds[a.kind]},
          {"rank", a.rank},
          {"mechanisms", a.mechanisms},
          {"selfStresses", a.selfStresses},
          {"softestEigenvalue", a.softestEigenvalue},
          {"stiffestEigenvalue", a.stiffestEigenvalue},
          {"modeRatio", a.modeRatio},
          {"rigidity", kRigidities[a.rigidity]},
          {"globallyRigid", a.globallyRigidKnown ? Json(a.globallyRigid) : Json(nullptr)},
          {"returns", returnsJson(a)},
          {"pieces", a.pieces},
          {"endedEarly", a.endedEarly},
          {"leastStiffness", a.leastStiffnessKnown ? Json(a.leastStiffness) : Json(nullptr)},
          {"criticalTimeStep", a.criticalTimeStep},
          {"safeTimeStep", a.safeTimeStep},
          {"springsOutside", a.springsOutside},
          {"piercingEdges", a.piercingEdges},
          {"volume", a.volume},
          {"remarks", a.remarks}};
}

Json settingsJson(const AnalysisSettings& s) {
  return {{"runs", s.runs},
          {"seed", s.seed},
          {"totalMass", s.totalMass},
          {"stiffness", s.stiffness},
          {"gravity", s.gravity}};
}

}  // namespace

std::string reportJson(const CookReport& r) {
  Json json = {{"schema", kSchemaVersion}, {"body", r.bodyFile}};
  json["meshFile"] = r.meshFile.empty() ? Json(nullptr) : Json(r.meshFile);
  json["mesh"] = meshJson(r.analysis.mesh);
  json["network"] = networkJson(r);
  json["settings"] = settingsJson(r.settings);
  json["analysis"] = analysisJson(r.analysis);
  json["cookSeconds"] = r.meshFile.empty() ? Json(nullptr) : Json(r.cookSeconds);
  json["analysisSeconds"] = r.analysisSeconds;
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace limber::demo
