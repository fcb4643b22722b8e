// SPDX-License-Identifier: Zlib
#include "cook/cook_report.h"

#include "cook/cook_options.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cstdarg>
#include <cstdio>
#include <vector>

namespace limber::demo {
namespace {

/// Like printf, for texts of at most 239 bytes.
[[gnu::format(printf, 1, 2)]] std::string format(const char* pattern, ...) {
  char line[240];
  va_list values;
  va_start(values, pattern);
  std::vsnprintf(line, sizeof line, pattern, values);
  va_end(values);
  return line;
}

std::string counted(std::size_t count, const char* one, const char* many) {
  return std::to_string(count) + " " + (count == 1 ? one : many);
}

std::string join(const std::vector<std::string>& parts) {
  std::string line;
  for (const std::string& part : parts) line += (line.empty() ? "" : ", ") + part;
  return line;
}

std::string bodyText(const CookReport& r) {
  if (r.meshFile.empty()) return r.bodyFile;
  return r.bodyFile + ", made of " + r.meshFile + format(" in %.2g s", r.cookSeconds);
}

std::string springText(const CookReport& r) {
  const auto counts = springCounts(*r.network);
  std::vector<std::string> kinds;
  for (std::size_t kind = 0; kind < counts.size(); ++kind) {
    if (counts[kind] > 0) kinds.push_back(std::to_string(counts[kind]) + " " + kSpringKinds.names[kind]);
  }
  if (kinds.empty()) return "none";
  return join(kinds) + format("; %.2f braces per point", bracesPerPoint(r.analysis));
}

/// What a material needs to know; empty: nothing is known.
std::string materialText(const SpringNetwork& network) {
  std::vector<std::string> parts;
  if (!network.tetrahedra.empty())
    parts.push_back(
        counted(network.tetrahedra.size(), "tetrahedron", "tetrahedra") +
        format(", springs of %.4g N/m for a Young's modulus of 1 Pa", network.stiffnessPerModulus));
  if (network.thickness > 0.0)
    parts.push_back(
        format("%.3g m %s", network.thickness, network.kind == NetworkKind::Rope ? "in diameter" : "thick"));
  if (network.volume > 0.0) parts.push_back(format("%.4g m^3", network.volume));
  return join(parts);
}

std::string drawnText(const RenderSurface& render) {
  if (render.triangles.empty()) return "nothing but the springs";
  const std::string size = counted(render.vertexToPoint.size(), "vertex", "vertices") + ", " +
                           counted(render.triangles.size(), "triangle", "triangles");
  if (render.skin.size() == 0) return size + ", on the points themselves";
  const auto weights = static_cast<double>(render.skin.weights.size());
  return size + format(", a skin of %.3g weights each", weights / static_cast<double>(render.skin.size()));
}

}  // namespace

std::string reportText(const CookReport& r) {
  // the column of names is as wide as that of describe()
  const auto row = [](const char* name, const std::string& value) {
    return format("%-19s ", name) + value + "\n";
  };
  std::string text;
  for (const std::string& choice : r.choices) text += choice + "\n";
  text += row("body", bodyText(r));
  text += row("springs", springText(r));
  if (const std::string material = materialText(*r.network); !material.empty())
    text += row("material", material);
  text += row("drawn", drawnText(r.network->render));
  return text + describe(r.analysis);
}

std::array<std::size_t, 4> springCounts(const SpringNetwork& network) {
  std::array<std::size_t, 4> counts{};
  for (const NetworkSpring& spring : network.springs) ++counts[static_cast<std::size_t>(spring.kind)];
  return counts;
}

double bracesPerPoint(const NetworkAnalysis& analysis) {
  return static_cast<double>(analysis.braces) /
         static_cast<double>(std::max<std::size_t>(analysis.points, 1));
}

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
          {"thickness", network.thickness},
          {"volume", network.volume},
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
          {"standingStiffness", a.standingStiffness && std::isfinite(*a.standingStiffness)
                                    ? Json(*a.standingStiffness)
                                    : Json(nullptr)},
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
