// SPDX-License-Identifier: Zlib
#pragma once

#include "accuracy/row_query.h"

namespace limber::bench {

/// How fast the first error of each ordered scene shrinks, as the slope in log-log: with the tick, and for
/// Limber with the substep. Free motion and contacts apart.
std::string convergenceTables(const Rows& rows);

/// A scene's slope of Limber's error over the substep: Verlet, 60 ticks a second, 1, 2, 4, 8 ... times the
/// stable number of substeps; the slope is that of the finest three.
struct SubstepOrder {
  std::string scene;
  Kind kind = Kind::Free;
  std::vector<double> errors;  ///< #factors
  double slope = 0.0;
};
std::vector<SubstepOrder> substepOrders(const Rows& rows);

}  // namespace limber::bench
