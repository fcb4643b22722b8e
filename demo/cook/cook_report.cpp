// SPDX-License-Identifier: Zlib
#include "cook/cook_report.h"

#include "cook/cook_names.h"

#include <array>
#include <cstdarg>
#include <cstdio>

namespace limber::demo {
namespace {

#if defined(__GNUC__)
__attribute__((format(printf, 1, 2)))
#endif
std::string
text(const char* format, ...) {
  char line[240];
  va_list values;
  va_start(values, format);
  std::vsnprintf(line, sizeof line, format, values);
  va_end(values);
  return line;
}

std::string row(const char* name, const std::string& value) {
  return text("%-12s ", name) + value + "\n";
}

std::string counted(std::size_t count, const char* one) {
  return std::to_string(count) + " " + one + (count == 1 ? "" : "s");
}

std::string springText(const SpringNetwork& network) {
  std::array<std::size_t, 4> counts{};
  for (const NetworkSpring& spring : network.springs) ++counts[static_cast<std::size_t>(spring.kind)];
  std::string list;
  for (std::size_t kind = 0; kind < counts.size(); ++kind) {
    if (counts[kind] == 0) continue;
    list += (list.empty() ? "" : ", ") + std::to_string(counts[kind]) + " " + kSpringKinds.names[kind];
  }
  return counted(network.springs.size(), "spring") + (list.empty() ? "" : " (" + list + ")");
}

std::string bodyText(const CookReport& report) {
  const SpringNetwork& network = *report.network;
  const double perPoint = static_cast<double>(report.analysis.braces) /
                          static_cast<double>(std::max<std::size_t>(report.analysis.points, 1));
  std::string line = counted(network.restPoints.size(), "point") + ", " + springText(network);
  if (report.analysis.braces > 0) line += text(", %.2f braces per point", perPoint);
  if (!network.tetrahedra.empty()) line += ", " + std::to_string(network.tetrahedra.size()) + " tetrahedra";
  return line;
}

std::string drawnText(const SpringNetwork& network) {
  const RenderSurface& render = network.render;
  const std::string vertices =
      counted(render.vertexToPoint.size(), "vertex").replace(0, 0, "") + ", " +
      counted(render.triangles.size(), "triangle");
  if (render.skin.size() == 0) return vertices + ", on the points themselves";
  const double each =
      static_cast<double>(render.skin.weights.size()) / static_cast<double>(render.skin.size());
  return vertices + text(", as a skin of %.1f weights each", each);
}

std::string rigidityText(const NetworkAnalysis& a) {
  std::string line = kRigidities[a.rigidity];
  line += ": " + counted(a.mechanisms, "mechanism") + ", " + counted(a.selfStresses, "self-stress");
  if (a.selfStresses != 1) line += "es", line.replace(line.size() - 3, 3, "es");
  line += text(" (rank %zu)", a.rank);
  if (a.modeRatio > 0.0) line += text(", softest mode %.2g of the stiffest", a.modeRatio);
  return line;
}

}  // namespace
}  // namespace limber::demo
