// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/network_analysis.h>

#include <string>
#include <vector>

namespace limber::bench {

/// A shape with the springs that one rule gives it.
struct NetworkRow {
  std::string mesh, rule;
  std::size_t points = 0, edges = 0, braces = 0;
  NetworkAnalysis analysis;
  double isotropy = -1.0;  ///< smallest over largest Young's modulus of 40 directions; below 0: not measured
  double seconds = 0.0;    ///< of cooking

  double perPoint() const { return double(braces) / double(points); }
  const ReturnRate& of(Deformation kind) const { return analysis.returns[static_cast<std::size_t>(kind)]; }
};

std::vector<std::string> networkColumns();
std::vector<std::string> networkCells(const NetworkRow& row);

/// One line for people.
std::string networkLine(const NetworkRow& row);
std::string networkHeading();

}  // namespace limber::bench
