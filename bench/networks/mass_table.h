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
};

std::vector<MassRow> measureMasses();
std::string massTable(const std::vector<MassRow>& rows);

}  // namespace limber::bench
