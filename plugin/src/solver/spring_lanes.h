// SPDX-License-Identifier: Zlib
#pragma once

#include "solver/cache_line.h"
#include "solver/instruction_set.h"
#include "solver/verlet_step.h"

#include <vector>

namespace limber {

/// Bodies of one network side by side, one per lane of a register: entry i of lane l is at [i * lanes + l].
/// Bodies that are all stepped equally often, have no links and no elastic limit,
/// and are all damped or all not, and have a volume term or all have not.
struct LaneBlock {
  struct Lane {
    SteppedBody body;
    unsigned revision = 0;  ///< of its springs when their constants were copied; 0: not yet
  };
  std::vector<Lane> lanes;  ///< 1 to laneCount(instructionSet) bodies

  AlignedNumbers restLength, extensionStiffness, compressionStiffness, dampHalf,
      dampFull;                                     // #springs
  AlignedNumbers restVolume, modulus, pressure;     // #components, 1, 1
  AlignedNumbers inverseRest;                       // #tetrahedra
  AlignedNumbers tetrahedronModulus, crushModulus;  // 1, 1
};

/// What changes in a step, in the order of a LaneBlock. Of no block in particular: that of thousands would
/// not stay in the caches.
struct LaneScratch {
  AlignedNumbers position, velocity, acceleration, inverseMass, force, earlierForce;  // 3 x #points
  AlignedNumbers direction;                                                           // 3 x #springs
  AlignedNumbers gradient, sums;  // 3 x #points, 4 x #components
  AlignedNumbers hold;            // #tetrahedra
};

/// As stepVerlet for each of the bodies, to the bit, whatever the instruction set.
/// Allocates only when block and scratch have not had as many points or springs before.
void stepLanes(LaneBlock& block, LaneScratch& scratch, double tick, int substeps, InstructionSet set);

}  // namespace limber
