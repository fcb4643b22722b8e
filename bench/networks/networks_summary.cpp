// SPDX-License-Identifier: Zlib
#include "networks/networks_summary.h"

#include "text_format.h"

#include <algorithm>
#include <cmath>
#include <functional>

namespace limber::bench {
namespace {

/// Ears and fins, and what is thin everywhere.
bool hasThinParts(const std::string& mesh) { return mesh == "rabbit302" || mesh == "tube60"; }

bool isConcave(const std::string& mesh) {
  for (const char* name : {"lshape90", "torus128", "star162", "noise162", "noise642", "rabbit302"})
    if (mesh == name) return true;
  return false;
}

std::string verdict(bool hit, const char* what, const std::string& value) {
  return format("  %-4s  %-78s %s\n", hit ? "hit" : "MISS", what, value.c_str());
}

const NetworkRow* find(const std::vector<NetworkRow>& rows, const std::string& mesh, const char* rule) {
  for (const NetworkRow& row : rows)
    if (row.mesh == mesh && row.rule == rule) return &row;
  return nullptr;
}

double worstReturn(const NetworkRow& row) {
  return std::min({row.analysis.allReturns().rate(), row.of(Deformation::Flatten).rate(),
                   row.of(Deformation::Inversion).rate()});
}

/// A line for the shapes of pipeline that miss, and the worst of those that hit.
std::string returnTargets(const std::vector<NetworkRow>& rows) {
  std::string text;
  for (const NetworkRow& row : rows) {
    if (row.rule != "pipeline") continue;
    const bool thin = hasThinParts(row.mesh);
    const bool hit = worstReturn(row) >= (thin ? 0.98 : 0.99) && row.perPoint() <= (thin ? 1.5 : 1.0);
    text += verdict(
        hit,
        thin ? "returns >= 98 %, also from flat and inside out, at <= 1.5 braces a point"
             : "returns >= 99 %, also from flat and inside out, at <= 1.0 braces a point",
        format("%s: %.1f %%, %.2f a point", row.mesh.c_str(), 100.0 * worstReturn(row), row.perPoint()));
  }
  return text;
}

std::string randomTargets(const std::vector<NetworkRow>& rows) {
  std::string text;
  for (const NetworkRow& row : rows) {
    const NetworkRow* other = row.rule == "pipeline" ? find(rows, row.mesh, "random") : nullptr;
    if (!other || !isConcave(row.mesh)) continue;
    const double points = 100.0 * (row.analysis.allReturns().rate() - other->analysis.allReturns().rate());
    text += verdict(points >= 50.0, "at least 50 points better than as many random braces, concave shapes",
                    format("%s: %.0f points", row.mesh.c_str(), points));
  }
  return text;
}

std::string outsideTarget(const std::vector<NetworkRow>& rows) {
  std::size_t outside = 0;
  for (const NetworkRow& row : rows)
    if (row.rule == "pipeline") outside += row.analysis.springsOutside;
  return verdict(outside == 0, "no added spring leaves the body", format("%zu do", outside));
}

std::string countTarget(const std::vector<CountRow>& rows) {
  const auto right = std::count_if(rows.begin(), rows.end(), [](const CountRow& r) { return r.right(); });
  return verdict(right == static_cast<std::ptrdiff_t>(rows.size()),
                 "mechanisms and self-stresses as expected",
                 format("%d of %zu shapes", static_cast<int>(right), rows.size()));
}

std::string skinTargets(const std::vector<SkinRow>& rows) {
  double affine = 0.0, smooth = 0.0;
  for (const SkinRow& row : rows) {
    affine = std::max(affine, row.affine);
    if (row.kind == "dense") smooth = std::max(smooth, row.smooth);
  }
  return verdict(affine <= 1e-10, "skins: affine error at most 1e-10", format("%.1e", affine)) +
         verdict(smooth <= 1e-3, "skins: smooth deformations within 1e-3 of the size (dense)",
                 format("%.1e", smooth));
}

}  // namespace

std::string summariseNetworks(const NetworkResults& r) {
  std::string text = countTable(r.counts);
  text += "\nreturns from seeded deformations, % of runs, by kind\n" + networkHeading();
  for (const NetworkRow& row : r.networks) text += networkLine(row);
  text += massTable(r.masses) + skinTable(r.skins) + materialTable(r.materials) + largeTable(r.large) +
          modelTable(r.models);
  text += "\ntargets\n" + countTarget(r.counts) + returnTargets(r.networks) + randomTargets(r.networks) +
          outsideTarget(r.networks) + massTargets(r.masses) + skinTargets(r.skins) +
          materialTargets(r.materials) + largeTargets(r.large) + modelTargets(r.models);
  return text;
}

}  // namespace limber::bench
