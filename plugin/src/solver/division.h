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

/// The springs of a regular network, such as a grid of cloth or a lattice, in batches of four that need no
/// rearrangement in vector registers. The points are cut into four strips of consecutive numbers: point i is
/// at slot i % length of strip i / length. Neighbours in a grid have numbers that differ by the same few
/// numbers everywhere, so in each strip springs connect the same slots. The four springs of a batch go from
/// the slot a, each from another strip, to the slot b of the same strip or of the next one.
struct Strips {
  static constexpr std::uint32_t kCount = 4;

  struct Batch {
    std::uint32_t a, b;   ///< slots, not equal: no two springs of a batch share a point
    std::uint32_t shift;  ///< 0, or 1: to the next strip; then the last spring is missing
  };

  std::uint32_t length = 0;  ///< number of slots; 0: the network is not regular
  std::vector<Batch> batches;
  std::vector<std::uint32_t> places;  ///< #springs, ordered as Division::order: 4 x batch + strip of a's end
};

/// Springs, or tetrahedra, in an order and in ranges for several threads. The phases follow one another. The
/// ranges of a phase share no point, so they can be computed at the same time. Each point gets its forces in
/// the same order with any number of threads. All ranges begin with a batch of the kernel: at a multiple of
/// four, or in `strips`.
struct Division {
  static constexpr std::size_t kPhases = 3;
  std::vector<std::uint32_t> order;  ///< indices in the network
  std::array<std::vector<Range>, kPhases> phases;

  std::vector<std::uint32_t> points;  ///< #points, in the order of the ranges of phase 0; empty if undivided
  std::vector<Range> pointRanges;     ///< of `points`, one for each range of phase 0

  Strips strips;                     ///< of springs
  std::vector<std::uint32_t> slots;  ///< of `strips`, likewise; empty if undivided
  std::vector<Range> slotRanges;     ///< of `slots`, one for each range of phase 0

  bool isDivided() const { return phases[0].size() > 1; }
};

/// Divides the springs of a network of some thousand springs or more; otherwise they are one range. Inside
/// the ranges no two springs of a batch of four (0 to 3, 4 to 7, ...) share a point, where possible, so that
/// the dampers of a batch can be computed at once. Springs that share a point are far apart, so that batches
/// need not wait for each other. The same applies to batches in strips.
Division divideSprings(const SpringNetwork& network);

/// The same for tetrahedra, which stay in the network's order inside a range.
Division divideTetrahedra(const SpringNetwork& network);

}  // namespace limber
