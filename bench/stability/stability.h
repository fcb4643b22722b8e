// SPDX-License-Identifier: Zlib
#pragma once

#include "stability/checks.h"

#include <cstdio>
#include <optional>
#include <string>

namespace limber::bench {

/// The result of one engine for one case and tick. Empty members: the case does not require this value, or
/// the engine does not support the case.
struct CaseResult {
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

bool gainsEnergy(const CaseResult& r);
bool drifts(const CaseResult& r);
bool losesSpin(const CaseResult& r);  ///< or gains it
/// Neither in its rest shape, nor in the mirror image, nor held in another shape.
bool staysMisshapen(const CaseResult& r);
bool isHeldElsewhere(const CaseResult& r);  ///< in another equilibrium, or by its spin
bool endsWrong(const CaseResult& r);
bool passes(const CaseResult& r);  ///< has run and has met all targets

/// Plays the case with an engine in ticks of dt. Writes a line per tick to `trace`, if given: time, energy
/// divided by that at the start, drift of momentum, largest speed, height of the lowest point.
CaseResult playCase(const HardCase& hard, const EngineChoice& choice, double dt, std::FILE* trace = nullptr);

}  // namespace limber::bench
