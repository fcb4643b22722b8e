// SPDX-License-Identifier: Zlib
#pragma once

#include <string>
#include <vector>

namespace limber::bench {

/// Mechanisms and self-stresses of the edges of a shape alone, counted and expected.
struct CountRow {
  std::string mesh;
  std::size_t points, springs, rank, mechanisms, selfStresses;
  std::size_t expectedMechanisms, expectedSelfStresses;
  double softest, stiffest;

  bool right() const { return mechanisms == expectedMechanisms && selfStresses == expectedSelfStresses; }
};

std::vector<CountRow> measureCounts();
std::string countTable(const std::vector<CountRow>& rows);

}  // namespace limber::bench
