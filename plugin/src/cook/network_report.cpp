// SPDX-License-Identifier: Zlib
#include <limber/network_analysis.h>

#include "cook/deformation_names.h"

#include <cstdarg>
#include <cstdio>

namespace limber {
namespace {

/// As printf, of numbers and short words.
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

const char* kindName(NetworkKind kind) {
  return kind == NetworkKind::Rope ? "on a line" : kind == NetworkKind::Cloth ? "flat" : "solid";
}

const char* rigidityName(Rigidity rigidity) {
  switch (rigidity) {
    case Rigidity::Flexible:
      return "flexible";
    case Rigidity::NearlyFlexible:
      return "nearly flexible";
    case Rigidity::Soft:
      return "soft";
    case Rigidity::Rigid:
      return "rigid";
  }
  return "";
}

const char* globalRigidity(const NetworkAnalysis& a) {
  if (a.globallyRigidKnown) return a.globallyRigid ? "yes" : "no";
  return a.endedEarly ? "not tested" : "not tested: too many points";
}

std::string returnLines(const NetworkAnalysis& a) {
  const ReturnRate all = a.allReturns();
  if (all.runs == 0) return {};
  std::string text = line("comes back          %.1f %% +- %.1f of %u runs, %u more as its mirror image",
                          100.0 * all.rate(), 100.0 * all.standardError(), all.runs, all.mirrored);
  for (std::size_t kind = 0; kind < kDeformations; ++kind)
    text += line("  %-17s %u of %u", kDeformationNames[kind], a.returns[kind].returned, a.returns[kind].runs);
  return text;
}

}  // namespace

std::string describe(const NetworkAnalysis& a) {
  std::string text = line("%s: %zu points, %zu springs, %zu of them braces", kindName(a.kind), a.points,
                          a.springs, a.braces);
  if (a.mesh.triangles > 0) text += describe(a.mesh) + "\n";
  if (a.volume > 0.0) text += line("volume              %.4g m^3", a.volume);
  text += line("rigidity            %s: rank %zu, %zu mechanisms, %zu self-stresses",
               rigidityName(a.rigidity), a.rank, a.mechanisms, a.selfStresses);
  text +=
      line("softest : stiffest  %.3g : %.3g = %.2g", a.softestEigenvalue, a.stiffestEigenvalue, a.modeRatio);
  text += line("globally rigid      %s", globalRigidity(a));
  text += returnLines(a);
  if (a.leastStiffness > 0.0)
    text += line("own weight          carried by springs of %.3g N/m and more", a.leastStiffness);
  text += line("time step           %.3g s critical, %.3g s safe", a.criticalTimeStep, a.safeTimeStep);
  if (a.volume > 0.0) text += line("springs outside     %zu", a.springsOutside);
  for (const std::string& remark : a.remarks) text += "! " + remark + "\n";
  return text;
}

}  // namespace limber
