// SPDX-License-Identifier: Zlib
#pragma once

// Velocity Verlet in vector registers: for several bodies of one network at once, or for four springs of one
// body.

#include "solver/verlet_step.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace limber {

// --- instruction sets --------------------------------------------------------------------------------------

/// Instruction set that computes several bodies at once. All sets give the same results, to the bit.
enum class InstructionSet : std::uint8_t { Scalar, Sse2, Avx2, Avx512, Neon };

/// Returns the number of bodies at once: 1, 2, 4, 8 or 2.
int laneCount(InstructionSet set);

/// Whether this machine and this build support `set`.
bool isAvailable(InstructionSet set);

/// Returns the widest available set.
InstructionSet bestInstructionSet();

const char* nameOf(InstructionSet set);

// --- several bodies at once --------------------------------------------------------------------------------

/// The numbers of bodies in lanes, which change in a step: entry i of lane l is at [i * lanes + l]. All
/// bodies share it, because the scratches of thousands of bodies would not fit into the caches.
struct LaneScratch {
  AlignedNumbers position, velocity, acceleration, inverseMass, force, earlierForce, start;  // 3 x #points
  AlignedNumbers direction, stretch;            // 3 x #springs, #springs
  AlignedNumbers gradient, sums;                // 3 x #points, 4 x #components
  AlignedNumbers stabilityScale;                // #tetrahedra
  AlignedNumbers motion;                        // a MotionSums
  AlignedNumbers regionCenter, regionDistance;  // 3 x #points, #points
  AlignedNumbers planes;                        // #planes x a Plane
  std::vector<unsigned> planePoints;            // #planes
  std::vector<unsigned> planeOf;                // #points: number of the plane; kNoPlane: none
  std::array<bool, 8> inPlanes;                 // #lanes: whether the body's contacts are in `planes`
};

/// Steps 1 to laneCount(set) bodies, each in a lane of the registers. They have equal springs, dampers,
/// volume terms and inverse masses (see canShareLanes), no links and no elastic limit. The results equal
/// those of stepVerlet() to the bit, with every instruction set. Also computes the bodies' `sums`, if they
/// are wanted. Allocates only if the scratch has had fewer points or springs before.
void stepLanes(SolverBody* const* bodies, std::size_t count, LaneScratch& scratch, double tick, int substeps,
               InstructionSet set);

/// Whether two bodies may be in one call of stepLanes().
bool canShareLanes(const SolverBody& a, const SolverBody& b);

// --- four springs at once ----------------------------------------------------------------------------------

/// A body's numbers in the layout of the kernel that computes four springs at a time (lane_kernels.h:
/// SpringBatchBody). The last batch is padded with springs or tetrahedra that use two additional points,
/// which are not part of the body and come last. In strips, entry i of `a` and `b` belongs to batch i, and
/// missing springs have no stiffness and no damping.
struct SpringBatchArrays {
  AlignedNumbers position, velocity, acceleration, inverseMass, force, earlierForce;  // 4 x (#points + 2)
  AlignedNumbers restLength, extensionStiffness, compressionStiffness, inverseLength, dampHalf, dampFull,
      stretch, crossingLoss;                   // #springs, padded; the last two if any has two stiffnesses
  AlignedNumbers gradient, sums;               // of the volume: 4 x (#points + 2), 8 x #components
  AlignedNumbers inverseRest, stabilityScale;  // #tetrahedra, padded
  std::vector<unsigned> corners;               // 4 x #tetrahedra, padded
  std::size_t springs = 0;                     // number of them, padded
  std::vector<unsigned> a, b;                  // #springs, padded; in strips #batches
  AlignedNumbers slots;                        // of StripBody
  std::vector<unsigned char> apart;            // #springs / 4: whether the four share no point; not in strips
  PackedPlanes planes;                         // of the present step
  unsigned revision = 0;                       // springs.revision of the copied constants; 0: none copied
};

/// Whether this machine can step a body four springs at a time: it needs AVX2 or NEON.
bool canStepSpringBatches();

/// Copies the body's state, and changed constants, into body.springBatches, which must be set. Allocates in
/// the first call only.
kernel::SpringBatchBody loadSpringBatches(SolverBody& body);

/// Packs the body's plane contacts, whose masses must be set, for the step.
void packPlanes(SolverBody& body);

/// Copies positions and velocities from body.springBatches to body.points, and the packed contacts to theirs.
void unloadSpringBatches(SolverBody& body);

/// Returns a view of the points during the step.
PointView viewOf(SpringBatchArrays& springBatches);

}  // namespace limber
