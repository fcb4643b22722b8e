// SPDX-License-Identifier: Zlib
#pragma once

// Velocity Verlet in vector registers: bodies of one network side by side, or four springs of one body at a
// time.

#include "solver/lane_kernels.h"
#include "solver/verlet_step.h"

#include <cstdint>
#include <vector>

namespace limber {

// --- instruction sets --------------------------------------------------------------------------------------

/// What the springs of several bodies are computed with at once. All give the same bits.
enum class InstructionSet : std::uint8_t { Scalar, Sse2, Avx2, Avx512 };

/// Bodies at once: 1, 2, 4 or 8.
int laneCount(InstructionSet set);

/// Whether this machine and this build have it.
bool isAvailable(InstructionSet set);

/// The widest available.
InstructionSet bestInstructionSet();

const char* nameOf(InstructionSet set);

// --- bodies side by side -----------------------------------------------------------------------------------

/// Bodies of one network side by side, one per lane of a register: entry i of lane l is at [i * lanes + l].
/// Bodies that are all stepped equally often, have no links and no elastic limit,
/// and are all damped or all not, and have a volume term or all have not.
struct LaneBlock {
  struct Lane {
    SolverBody body;
    unsigned revision = 0;  ///< of its springs when constants and dampers were copied; 0: not yet
    double substep = 0.0;   ///< s, of the dampers
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
  AlignedNumbers stabilityScale;  // #tetrahedra
};

/// As stepVerlet for each of the bodies, to the bit, whatever the instruction set.
/// Allocates only when block and scratch have not had as many points or springs before.
void stepLanes(LaneBlock& block, LaneScratch& scratch, double tick, int substeps, InstructionSet set);

// --- four springs of a body --------------------------------------------------------------------------------

/// A body's numbers as the kernel that takes four springs at a time wants them (lane_kernels.h:
/// SpringBatchBody). Two points without a body behind them come last: springs and tetrahedra that fill up the
/// last four have these.
struct SpringBatchArrays {
  AlignedNumbers position, velocity, acceleration, inverseMass, force, earlierForce;  // 4 x (#points + 2)
  AlignedNumbers restLength, extensionStiffness, compressionStiffness, inverseLength, dampHalf,
      dampFull;                                // #springs, filled up
  bool sameStiffness = false;                  // of all springs, extended and compressed
  AlignedNumbers gradient, sums;               // of the volume: 4 x (#points + 2), 8 x #components
  AlignedNumbers inverseRest, stabilityScale;  // #tetrahedra, filled up
  std::vector<unsigned> corners;               // 4 x #tetrahedra, filled up
  std::vector<unsigned> a, b;                  // #springs, filled up
  std::vector<unsigned char> apart;            // #springs / 4: whether the four share no point
  unsigned revision = 0;                       // of the springs when their constants were copied; 0: not yet
};

/// Whether this machine can: AVX2.
bool canStepSpringBatches();

/// Copies the body's state, and what else has changed, into body.quads, which must be set. Allocates at the
/// first call only. `contacts` must outlive the result; nullptr for a body that is stepped part by part.
kernel::SpringBatchBody loadSpringBatches(SolverBody& body, const kernel::ContactCalls* contacts);

/// Copies positions and velocities back.
void unloadSpringBatches(SolverBody& body);

/// The points as they are while they are stepped.
PointView viewOf(SpringBatchArrays& springBatches);

/// As stepVerlet for a body without links and elastic limit, to the bit. body.quads must be set. Allocates at
/// the first call only.
void stepSpringBatches(SolverBody& body, double tick, int substeps);

}  // namespace limber
