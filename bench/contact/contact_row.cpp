// SPDX-License-Identifier: Zlib
#include "contact/contact_row.h"

#include "csv_table.h"

#include <algorithm>

namespace limber::bench {
namespace {

std::string noCommas(std::string text) {
  std::replace(text.begin(), text.end(), ',', ';');
  return text;
}

}  // namespace

std::vector<std::string> contactColumns() {
  return {"scene",
          "engine",
          "bodies",
          "points",
          "tick_ms_median",
          "tick_ms_worst",
          "ratio_to_btsoftbody",
          "ratio_to_bare_bullet",
          "us_per_point",
          "deepest_penetration_share",
          "residual_speed",
          "rms_strain",
          "asleep_share",
          "wall_ms_median",
          "repeats",
          "role",
          "error"};
}

std::vector<std::string> contactCells(const ContactRow& row) {
  const auto cell = [&](double value) { return row.ran() ? numberCell(value) : std::string(); };
  const auto ratio = [&](const std::optional<double>& value) { return value ? cell(*value) : std::string(); };
  const bool moves = row.role == Role::Airborne || row.role == Role::Landing;
  return {row.scene,
          row.engine,
          countCell(row.bodies),
          countCell(row.points),
          cell(row.tickMedian),
          cell(row.tickWorst),
          ratio(row.toSoftBody),
          ratio(row.toSpheres),
          cell(row.microsecondsPerPoint()),
          cell(row.penetration),
          moves ? std::string() : cell(row.residualSpeed),
          row.hasSprings ? cell(row.stretch) : std::string(),
          cell(row.asleep),
          cell(row.wallMedian),
          countCell(static_cast<std::uint64_t>(row.repeats)),
          nameOf(row.role),
          noCommas(row.error)};
}

}  // namespace limber::bench
