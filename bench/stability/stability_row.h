// SPDX-License-Identifier: Zlib
#pragma once

#include "stability/shape_check.h"

#include <optional>
#include <string>
#include <vector>

namespace limber::bench {

/// What one engine made of one case at one tick. Empty: the case does not ask for it, or the engine cannot
/// have it.
struct StabilityRow {
  std::string group, name, engine, setting;
  double dt = 0.0;  ///< s
  unsigned seed = 1;
  double stiffness = 0.0;           ///< N/m
  std::string reason;               ///< why the engine cannot have the case; empty: it has run
  bool finite = true;               ///< neither not a number nor farther away than a million sizes
  double energyRatio = 0.0;         ///< largest energy over that at the start
  double rounding = 0.0;            ///< what the rounding of Bullet's numbers may have added to the ratio
  std::optional<double> drift;      ///< largest change of momentum over the sum of m |v|
  std::optional<double> spinDrift;  ///< largest change of angular momentum over what there could be of it
  std::optional<ShapeCheck> shape;  ///< of the worst body
  std::optional<std::size_t> wrongSide;  ///< points that ended inside or behind what they hit

  bool ran() const { return reason.empty(); }
};

constexpr double kEnergyTarget = 1.001, kDriftTarget = 1e-6;
constexpr double kSpinTarget = 1e-3;

bool gainsEnergy(const StabilityRow& row);
bool drifts(const StabilityRow& row);
bool losesSpin(const StabilityRow& row);  ///< or has gained some
/// Neither in its shape nor in its mirror image nor held in another one.
bool staysMisshapen(const StabilityRow& row);
bool isHeldElsewhere(const StabilityRow& row);  ///< in another balance, or by its spin
bool endsWrong(const StabilityRow& row);
bool passes(const StabilityRow& row);  ///< has run and missed nothing

std::vector<std::string> stabilityColumns();
std::vector<std::string> stabilityCells(const StabilityRow& row);

}  // namespace limber::bench
