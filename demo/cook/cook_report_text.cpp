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

std::string materialText(const SpringNetwork& network) {
  return counted(network.tetrahedra.size(), "tetrahedron", "tetrahedra") +
         format(", springs of %.4g N/m for a Young's modulus of 1 Pa", network.stiffnessPerModulus);
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
  // names as wide as those of describe()
  const auto row = [](const char* name, const std::string& value) {
    return format("%-19s ", name) + value + "\n";
  };
  std::string text = row("body", bodyText(r));
  text += row("springs", springText(r));
  if (!r.network->tetrahedra.empty()) text += row("material", materialText(*r.network));
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

}  // namespace limber::demo
