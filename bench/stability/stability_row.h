// SPDX-License-Identifier: Zlib
#pragma once

#include "stability/shape_check.h"

#include <optional>
#include <string>
#include <vector>

namespace limber::bench {

/// The result of one engine for one case and tick. Empty members: the case does not require this value, or
/// the engine does not support the case.
struct StabilityRow {
  std::string group, name, engine, setting;
  double dt = 0.0;  ///< s
  unsigned seed = 1;
  double stiffness = 0.0;           ///< N/m
  std::string reason;               ///< why the engine does not support the case; empty: it has run
  bool finite = true;               ///< no value is NaN, and no point is farther away than a million sizes
  double energyRatio = 0.0;         ///< largest energy over that at the start
  double rounding = 0.0;            ///< largest part of the ratio that may be rounding of Bullet's numbers
  std::optional<double> drift;      ///< largest change of momentum over the sum of m |v|
  std::optional<double> spinDrift;  ///< largest change of angular momentum over the largest possible value
  std::optional<ShapeCheck> shape;  ///< of the worst body
  std::optional<std::size_t> wrongSide;  ///< points that ended inside or behind an obstacle

  bool ran() const { return reason.empty(); }
};

constexpr double kEnergyTarget = 1.001, kDriftTarget = 1e-6;
constexpr double kSpinTarget = 1e-3;

bool gainsEnergy(const StabilityRow& row);
bool drifts(const StabilityRow& row);
bool losesSpin(const StabilityRow& row);  ///< or gains it
/// Neither in its rest shape, nor in the mirror image, nor held in another shape.
bool staysMisshapen(const StabilityRow& row);
bool isHeldElsewhere(const StabilityRow& row);  ///< in another equilibrium, or by its spin
bool endsWrong(const StabilityRow& row);
bool passes(const StabilityRow& row);  ///< has run and has met all targets

std::vector<std::string> stabilityColumns();
std::vector<std::string> stabilityCells(const StabilityRow& row);

}  // namespace limber::bench
