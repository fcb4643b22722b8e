// SPDX-License-Identifier: Zlib
#include "networks/mass_table.h"

#include "support/mass_errors.h"
#include "support/network_shapes.h"
#include "text_format.h"

#include <limber/network_builder.h>

#include <algorithm>

namespace limber::bench {

namespace {

/// What it takes to match the moments: points inside.
double inertiaWithPointsInside(const TriangleMesh& mesh) {
  const Result<SharedNetwork> filled = buildMaterialNetwork(mesh);
  if (!filled) return -1.0;
  return test::shareMass(MassRule::Moments, (*filled)->restPoints, (*filled)->surface).inertiaError;
}

std::string names(const std::vector<const MassRow*>& rows) {
  std::string text;
  for (const MassRow* row : rows) text += " " + row->mesh;
  return text;
}

}  // namespace

std::vector<MassRow> measureMasses() {
  const std::pair<MassRule, const char*> rules[] = {
      {MassRule::Equal, "equal"}, {MassRule::Area, "area"}, {MassRule::Moments, "moments"}};
  std::vector<MassRow> rows;
  for (const network_shapes::NamedShape& shape : network_shapes::solids()) {
    const SharedNetwork network = network_shapes::bare(shape.make());
    for (const auto& [rule, name] : rules) {
      const test::MassFractions m = test::shareMass(rule, network->restPoints, network->surface);
      const auto [least, most] = std::minmax_element(m.shares.begin(), m.shares.end());
      rows.push_back({shape.name, name, m.centreError, m.inertiaError, *most / *least});
      rows.back().unsolvable = m.leastMisfit > 0.0;
      rows.back().wantsPoints = m.leastMisfitAnyMass > 0.0;
      if (rows.back().unsolvable) rows.back().filledInertia = inertiaWithPointsInside(shape.make());
    }
  }
  return rows;
}

std::string massTable(const std::vector<MassRow>& rows) {
  std::string text =
      "\nmasses of the points against the solid: offset of the centre (of the size), misfit of the "
      "inertia, largest share over smallest\n";
  for (std::size_t i = 0; i + 2 < rows.size(); i += 3) {
    text += format("%-9s", rows[i].mesh.c_str());
    for (std::size_t k = i; k < i + 3; ++k)
      text += format(" | %-7s %6.4f %7.2f %% %5.1f", rows[k].rule.c_str(), rows[k].centreError,
                     100.0 * rows[k].inertiaError, rows[k].ratio);
    text += "\n";
  }
  return text;
}

std::string massTargets(const std::vector<MassRow>& rows) {
  std::vector<const MassRow*> hits, misses, noPoints, bounded, filled;
  for (const MassRow& row : rows) {
    if (row.rule != "moments") continue;
    if (!row.unsolvable) (row.matched() ? hits : misses).push_back(&row);
    if (row.unsolvable) (row.wantsPoints ? noPoints : bounded).push_back(&row);
    if (row.filledInertia >= 0.0 && row.filledInertia <= 0.01) filled.push_back(&row);
  }
  return format("  %-4s  %-78s %zu of %zu%s\n", misses.empty() ? "hit" : "MISS",
                "moment-matched masses within 1 % where solvable", hits.size(), hits.size() + misses.size(),
                names(misses).c_str()) +
         format("        proven unsolvable, all points too far out: %zu%s\n", noPoints.size(),
                names(noPoints).c_str()) +
         format("        proven unsolvable, with masses of 0.2 to 10 times the mean: %zu%s\n", bounded.size(),
                names(bounded).c_str()) +
         format("        of these %zu, matched with points inside (material mode): %zu\n",
                noPoints.size() + bounded.size(), filled.size());
}

}  // namespace limber::bench
