// SPDX-License-Identifier: Zlib
#pragma once

#include "bullet/tick_group.h"
#include "solver/simd_steps.h"

#include <vector>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

/// Which bodies are stepped side by side: those of one network that take equally many substeps of Verlet.
/// Kept from tick to tick, so that a lane whose body stays the same need not copy its springs again.
class StepPlan {
 public:
  /// Steps all groups that are awake and in no cluster. Order and result do not depend on how they are put
  /// together.
  void step(std::vector<TickGroup>& groups, double tick);

  /// Forgets the bodies: the groups have been made anew.
  void clear();

 private:
  struct Candidate {
    std::size_t network;  ///< number of the body's network in order of first appearance
    int substeps;
    bool damped;
    int volumes;  ///< 0: no volume term, -1: of a body whose scale mirrors it, else 1
    std::size_t group;
    bool fitsWith(const Candidate& other) const;
    bool operator<(const Candidate& other) const;
  };

  void number(const std::vector<TickGroup>& groups);
  /// Steps the groups that do not fit into lanes and sorts the others into candidates_.
  void stepOrCollect(std::vector<TickGroup>& groups, double tick);
  void stepRun(std::vector<TickGroup>& groups, std::size_t begin, std::size_t end, double tick);
  void stepBlock(std::vector<TickGroup>& groups, std::size_t begin, std::size_t end, double tick);

  SharedFactors factors_;
  InstructionSet set_ = bestInstructionSet();
  std::vector<std::size_t> networkOf_;  ///< #groups
  std::vector<Candidate> candidates_;
  std::vector<LaneBlock> blocks_;
  LaneScratch scratch_;
  std::size_t blocksUsed_ = 0;
};

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
