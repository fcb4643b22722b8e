// SPDX-License-Identifier: Zlib
#pragma once

// How the springs and tetrahedra of a large body are divided among threads.

#include <limber/spring_network.h>

#include <array>
#include <cstdint>
#include <vector>

namespace limber {

/// Consecutive springs or tetrahedra, in the order in which a body computes them.
struct Range {
  std::uint32_t begin, end;
};

/// Springs, or tetrahedra, in an order and in ranges for several threads. The phases follow one another. The
/// ranges of a phase share no point, so they can be computed at the same time. Each point gets its forces in
/// the same order with any number of threads. All ranges begin at a multiple of four (a batch of the kernel).
struct Division {
  static constexpr std::size_t kPhases = 3;
  std::vector<std::uint32_t> order;  ///< indices in the network
  std::array<std::vector<Range>, kPhases> phases;

  std::vector<std::uint32_t> points;  ///< #points, in the order of the ranges of phase 0; empty if undivided
  std::vector<Range> pointRanges;     ///< of `points`, one for each range of phase 0

  bool isDivided() const { return phases[0].size() > 1; }
};

/// Divides the springs of a network of some thousand springs or more; otherwise they are one range. Inside
/// the ranges they are in the order of orderApart().
Division divideSprings(const SpringNetwork& network);

/// The same for tetrahedra, which stay in the network's order inside a range.
Division divideTetrahedra(const SpringNetwork& network);

/// Returns an order of these springs. Where possible, no two springs of a batch of four (0 to 3, 4 to 7, ...)
/// share a point, so that the dampers of a batch can be computed at once, and springs that share a point are
/// far apart, so that batches need not wait for each other. Springs that are near each other in the given
/// order stay near each other.
std::vector<std::uint32_t> orderApart(const SpringNetwork& network, std::vector<std::uint32_t> springs);

}  // namespace limber
