// SPDX-License-Identifier: Zlib
#include "cook/cook_names.h"
#include "cook/cook_report.h"

#include <algorithm>
#include <cstdarg>
#include <cstdio>
#include <vector>

namespace limber::demo {
namespace {

/// Of numbers and short words: at most 240 bytes.
[[gnu::format(printf, 1, 2)]] std::string format(const char* pattern, ...) {
  char line[240];
  va_list values;
  va_start(values, pattern);
  std::vsnprintf(line, sizeof line, pattern, values);
  va_end(values);
  return line;
}

std::string row(const char* name, const std::string& value) { return format("%-10s ", name) + value + "\n"; }

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

std::string meshText(const NetworkAnalysis& a) {
  return describe(a.mesh) + (a.volume > 0.0 ? format(", %.4g m^3", a.volume) : std::string());
}

std::string networkText(const CookReport& r) {
  const SpringNetwork& network = *r.network;
  const auto counts = springCounts(network);
  std::vector<std::string> kinds;
  for (std::size_t kind = 0; kind < counts.size(); ++kind) {
    if (counts[kind] > 0) kinds.push_back(std::to_string(counts[kind]) + " " + kSpringKinds.names[kind]);
  }
  std::string line = counted(network.restPoints.size(), "point", "points") + ", " +
                     counted(network.springs.size(), "spring", "springs");
  if (!kinds.empty()) line += ": " + join(kinds);
  if (r.analysis.braces > 0) line += format(", %.2f braces per point", bracesPerPoint(r.analysis));
  if (!network.tetrahedra.empty()) {
    line += "; " + counted(network.tetrahedra.size(), "tetrahedron", "tetrahedra") +
            format(", %.4g N/m per Pa", network.stiffnessPerModulus);
  }
  return line;
}

std::string drawnText(const RenderSurface& render) {
  if (render.triangles.empty()) return "nothing but the springs";
  const std::string size = counted(render.vertexToPoint.size(), "vertex", "vertices") + ", " +
                           counted(render.triangles.size(), "triangle", "triangles");
  if (render.skin.size() == 0) return size + ", on the points themselves";
  const double weights = static_cast<double>(render.skin.weights.size());
  return size + format(", a skin of %.3g weights each", weights / static_cast<double>(render.skin.size()));
}

std::string smallText(const NetworkAnalysis& a) {
  std::string line = kRigidities[a.rigidity];
  line += ": " + counted(a.mechanisms, "mechanism", "mechanisms") + ", " +
          counted(a.selfStresses, "self-stress", "self-stresses") + format(", rank %zu", a.rank);
  if (a.modeRatio > 0.0) line += format(", softest mode %.2g of the stiffest", a.modeRatio);
  return line;
}

const char* globalText(const NetworkAnalysis& a) {
  if (!a.globallyRigidKnown) return "not tested: too many points";
  return a.globallyRigid ? "generically one shape only" : "other shapes may fit the same springs";
}

std::string rateText(const ReturnRate& r) {
  return format("%.1f %% +- %.1f %% of %u return", 100.0 * r.rate(), 100.0 * r.standardError(), r.runs);
}

std::string kindText(const char* name, const ReturnRate& r) {
  std::string line = format("%s %u of %u", name, r.returned, r.runs);
  if (r.mirrored > 0) line += format(" (%u mirrored)", r.mirrored);
  return line;
}

std::string largeRows(const NetworkAnalysis& a) {
  const ReturnRate all = a.allReturns();
  if (all.runs == 0) return row("large", "not tried");
  constexpr std::size_t kInAll = 5;  // the first kinds, those of allReturns()
  std::vector<std::string> first, others;
  for (std::size_t kind = 0; kind < kDeformations; ++kind) {
    if (a.returns[kind].runs == 0) continue;
    (kind < kInAll ? first : others).push_back(kindText(kDeformationNames.names[kind], a.returns[kind]));
  }
  return row("large", rateText(all)) + row("", join(first)) + (others.empty() ? "" : row("", join(others)));
}

std::string weightText(const CookReport& r) {
  return format("carries its own %g kg from %.3g N/m on", r.settings.totalMass, r.analysis.leastStiffness);
}

std::string stepText(const CookReport& r) {
  return format("%.3g ms critical, %.3g ms safe at any deformation (%g N/m, velocity Verlet, undamped)",
                1e3 * r.analysis.criticalTimeStep, 1e3 * r.analysis.safeTimeStep, r.settings.stiffness);
}

std::string outsideText(const NetworkAnalysis& a) {
  if (!a.mesh.watertight()) return "the surface is open";
  return a.springsOutside == 0 ? "no spring leaves the body"
                               : counted(a.springsOutside, "spring leaves", "springs leave") + " the body";
}

}  // namespace

std::string reportText(const CookReport& r) {
  const NetworkAnalysis& a = r.analysis;
  const bool fromMesh = a.mesh.vertices > 0;
  std::string text = row("body", bodyText(r));
  if (fromMesh) text += row("mesh", meshText(a));
  text += row("network", kNetworkKinds[a.kind] + (", " + networkText(r)));
  text += row("drawn", drawnText(r.network->render));
  text += row("small", smallText(a));
  text += row("global", globalText(a));
  text += largeRows(a);
  if (a.leastStiffness > 0.0) text += row("weight", weightText(r));
  text += row("time step", stepText(r));
  if (fromMesh) text += row("outside", outsideText(a));
  for (const std::string& remark : a.remarks) text += row("remark", remark);
  return text;
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

}  // namespace limber::demo
