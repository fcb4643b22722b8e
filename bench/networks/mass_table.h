// SPDX-License-Identifier: Zlib
#pragma once

#include <string>
#include <vector>

namespace limber::bench {

/// How well point masses stand for the solid.
struct MassRow {
  std::string mesh, rule;
  double centreError = 0.0;   ///< of the size
  double inertiaError = 0.0;  ///< of the solid's inertia
  double ratio = 1.0;         ///< largest over smallest share

  // of the rule moments
  bool unsolvable = false;      ///< proven: no shares within the bounds match
  bool wantsPoints = false;     ///< proven even of shares without bounds
  double filledInertia = -1.0;  ///< where unsolvable: misfit with the points inside of material mode
  bool matched() const { return centreError <= 0.01 && inertiaError <= 0.01; }
};

std::vector<MassRow> measureMasses();
std::string massTable(const std::vector<MassRow>& rows);

/// Counts the shapes that have a solution; names those proven to have none.
std::string massTargets(const std::vector<MassRow>& rows);

}  // namespace limber::bench
