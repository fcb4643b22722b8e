// SPDX-License-Identifier: Zlib
#pragma once

// Velocity Verlet in vector registers for four springs of one body at once.

#include "solver/simd_steps.h"

#include <cstddef>
#include <vector>

namespace limber {

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

/// Whether this machine supports stepSpringBatches(): it needs AVX2 or NEON.
bool canStepSpringBatches();

/// Copies the body's state, and changed constants, into body.springBatches, which must be set. Allocates in
/// the first call only. `contacts` must outlive the result; nullptr if the parts of the step are called one
/// by one.
kernel::SpringBatchBody loadSpringBatches(SolverBody& body, const kernel::ContactCalls* contacts);

/// Packs the body's plane contacts, whose masses must be set, for the step.
void packPlanes(SolverBody& body);

/// Copies positions and velocities from body.springBatches to body.points, and the packed contacts to theirs.
void unloadSpringBatches(SolverBody& body);

/// Returns a view of the points during the step.
PointView viewOf(SpringBatchArrays& springBatches);

/// Steps a body without links and elastic limit. The results equal those of stepVerlet() to the bit.
/// body.springBatches must be set. Allocates in the first call only.
void stepSpringBatches(SolverBody& body, double tick, int substeps);

}  // namespace limber
