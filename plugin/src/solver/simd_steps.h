// SPDX-License-Identifier: Zlib
#pragma once

// Velocity Verlet in vector registers for several bodies of one network at once.

#include "solver/lane_kernels.h"
#include "solver/verlet_step.h"

#include <array>
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

// --- arguments of the kernels ------------------------------------------------------------------------------

kernel::VolumeBody volumeBody(VolumeArrays& volumes);
kernel::TetrahedronBody tetrahedronBody(const TetrahedronVolumes& volumes);

}  // namespace limber
