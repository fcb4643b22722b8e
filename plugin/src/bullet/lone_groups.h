// SPDX-License-Identifier: Zlib

// This header declares the step of the groups that touch nothing that moves.

#pragma once

#include "bullet/linked_group.h"

#include <limber/soft_body_system.h>

#include <chrono>
#include <mutex>
#include <vector>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

/// Measures the stages of a tick, one after the other.
class LapTimer {
 public:
  /// Returns the milliseconds since the last call, or since the timer was made.
  double lap() {
    const Clock::time_point begin = begin_;
    begin_ = Clock::now();
    return std::chrono::duration<double, std::milli>(begin_ - begin).count();
  }

 private:
  using Clock = std::chrono::steady_clock;
  Clock::time_point begin_ = Clock::now();
};

/// Steps the groups that are in no island. Bodies of one model with the same number of Verlet substeps are
/// stepped together in SIMD lanes.
class LoneGroups {
 public:
  /// Chooses the steppers of all groups that are in no island, steps these groups and writes them to Bullet.
  /// Does the three in blocks of groups, whose data stay in the processor's cache. The results do not depend
  /// on the blocks, nor on which bodies share lanes. Adds times and work to `profile`.
  void step(const AwakeGroups& groups, double tick, const Parallel& parallel, TickProfile& profile);

 private:
  /// Memory for a block.
  struct Block {
    AwakeGroups groups;
    std::size_t forLanes = 0;       ///< number of the first groups, which can share lanes
    std::vector<std::size_t> runs;  ///< #runs + 1, begins in `groups`
    std::vector<SolverBody*> bodies;
    LaneScratch lanes;
    TickProfile work;
  };

  void collect(const AwakeGroups& groups);
  /// Moves the groups that a team steps out of `lone_`.
  void takeLarge();
  void stepLarge(double tick, const Parallel& parallel, TickProfile& profile);
  /// Sorts `lone_` by model and splits it into blocks.
  void makeBlocks();
  void stepBlock(Block& block, double tick);
  /// Splits a block into runs of bodies that are stepped together.
  void makeRuns(Block& block) const;
  void stepRun(Block& block, std::size_t run, double tick);

  SharedFactors factors_;
  InstructionSet set_ = bestInstructionSet();
  AwakeGroups lone_;
  AwakeGroups large_;
  std::vector<std::size_t> blocks_;  ///< #blocks + 1, begins in lone_
  ScratchPool<Block> scratch_;
  std::mutex lock_;  ///< of `sum_`
  TickProfile sum_;  ///< of the blocks
};

/// Reports what the step of a group was, and writes it to Bullet.
void writeGroup(LinkedGroup& group, btScalar tick, TickProfile& work);

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
