// SPDX-License-Identifier: Zlib
#include "stability/stability_row.h"

#include "csv_table.h"

#include <algorithm>

namespace limber::bench {
namespace {

const char* const kNotAvailable = "n/a";

std::string noCommas(std::string text) {
  std::replace(text.begin(), text.end(), ',', ';');
  return text;
}

}  // namespace

bool gainsEnergy(const StabilityRow& row) {
  return row.ran() && !(row.energyRatio <= kEnergyTarget + row.rounding);
}

bool drifts(const StabilityRow& row) { return row.ran() && row.drift && !(*row.drift <= kDriftTarget); }

bool losesSpin(const StabilityRow& row) {
  return row.ran() && row.spinDrift && !(*row.spinDrift <= kSpinTarget);
}

bool staysMisshapen(const StabilityRow& row) {
  return row.ran() && row.shape && row.shape->shape == Shape::Lost;
}

bool isHeldElsewhere(const StabilityRow& row) {
  if (!row.ran() || !row.shape) return false;
  const Shape shape = row.shape->shape;
  return shape == Shape::Other || shape == Shape::Saddle || shape == Shape::Spinning;
}

bool endsWrong(const StabilityRow& row) { return row.ran() && row.wrongSide.value_or(0) > 0; }

bool passes(const StabilityRow& row) {
  return row.ran() && row.finite && !gainsEnergy(row) && !drifts(row) && !losesSpin(row) &&
         !staysMisshapen(row) && !endsWrong(row);
}

std::vector<std::string> stabilityColumns() {
  return {"case",        "engine",   "setting",       "finite", "energy_ratio", "momentum_drift",
          "recovered",   "dt",       "seed",          "k",      "group",        "wrong_side",
          "shape_error", "rounding", "angular_drift", "passed", "reason"};
}

std::vector<std::string> stabilityCells(const StabilityRow& row) {
  const bool ran = row.ran(), shape = ran && row.shape;
  return {row.name,
          row.engine,
          row.setting,
          ran ? (row.finite ? "1" : "0") : kNotAvailable,
          ran ? numberCell(row.energyRatio) : kNotAvailable,
          ran && row.drift ? numberCell(*row.drift) : kNotAvailable,
          shape ? nameOf(row.shape->shape) : kNotAvailable,
          numberCell(row.dt),
          countCell(row.seed),
          numberCell(row.stiffness),
          row.group,
          ran && row.wrongSide ? countCell(*row.wrongSide) : kNotAvailable,
          shape ? numberCell(row.shape->error) : kNotAvailable,
          ran ? numberCell(row.rounding) : kNotAvailable,
          ran && row.spinDrift ? numberCell(*row.spinDrift) : kNotAvailable,
          ran ? (passes(row) ? "1" : "0") : kNotAvailable,
          noCommas(row.reason)};
}

}  // namespace limber::bench
