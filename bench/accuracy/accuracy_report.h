// SPDX-License-Identifier: Zlib
#pragma once

// The report on all rows, for people.

#include "accuracy/accuracy_row.h"

namespace limber::bench {

/// Returns a report for people: the best result of each engine in each scene, orders of convergence, and
/// targets with hit or MISS.
std::string summariseAccuracy(const std::vector<Scene>& scenes, const std::vector<AccuracyRow>& rows);

/// Returns tables of the convergence of the first error of each ordered scene, as slope in log-log: over the
/// tick, and for Limber over the substep. Free motion and contacts have separate tables.
std::string convergenceTables(const Rows& rows);

/// The order of Limber's error over the substep in a scene: Verlet, 60 ticks a second, 1, 2, 4, 8 ... times
/// the stable number of substeps. The slope is that of the finest three.
struct SubstepOrder {
  std::string scene;
  Kind kind = Kind::Free;
  std::vector<double> errors;  ///< #factors
  double slope = 0.0;
};
std::vector<SubstepOrder> substepOrders(const Rows& rows);

/// Returns Limber's targets and results, with "hit" or "MISS". Targets without rows are left out.
std::string targetTable(const Rows& rows);

}  // namespace limber::bench
