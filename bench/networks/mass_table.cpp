// SPDX-License-Identifier: Zlib
#include "networks/mass_table.h"

#include "cook/mass_shares.h"
#include "support/network_shapes.h"
#include "text_format.h"

#include <algorithm>

namespace limber::bench {

std::vector<MassRow> measureMasses() {
  const std::pair<MassRule, const char*> rules[] = {
      {MassRule::Equal, "equal"}, {MassRule::Area, "area"}, {MassRule::Moments, "moments"}};
  std::vector<MassRow> rows;
  for (const network_shapes::NamedShape& shape : network_shapes::solids()) {
    const SharedNetwork network = network_shapes::bare(shape.make());
    for (const auto& [rule, name] : rules) {
      const MassShares m = shareMass(rule, network->restPoints, network->surface);
      const auto [least, most] = std::minmax_element(m.shares.begin(), m.shares.end());
      rows.push_back({shape.name, name, m.centreError, m.inertiaError, *most / *least});
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

}  // namespace limber::bench
