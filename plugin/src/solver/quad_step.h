// SPDX-License-Identifier: Zlib
#pragma once

#include "solver/cache_line.h"
#include "solver/lane_kernels.h"
#include "solver/point_view.h"
#include "solver/verlet_step.h"

#include <vector>

namespace limber {

/// A body's numbers as the kernel that takes four springs at a time wants them (lane_kernels.h: QuadBody).
/// Two points without a body behind them come last: springs and tetrahedra that fill up the last four have
/// these.
struct QuadArrays {
  AlignedNumbers position, velocity, acceleration, inverseMass, force, earlierForce;  // 4 x (#points + 2)
  AlignedNumbers restLength, extensionStiffness, compressionStiffness, inverseLength, dampHalf,
      dampFull;                      // #springs, filled up
  bool sameStiffness = false;        // of all springs, extended and compressed
  AlignedNumbers gradient, sums;     // of the volume: 4 x (#points + 2), 8 x #components
  AlignedNumbers inverseRest, hold;  // #tetrahedra, filled up
  std::vector<unsigned> corners;     // 4 x #tetrahedra, filled up
  std::vector<unsigned> a, b;        // #springs, filled up
  std::vector<unsigned char> apart;  // #springs / 4: whether the four share no point
  unsigned revision = 0;             // of the springs when their constants were copied; 0: not yet
};

/// Whether this machine can: AVX2.
bool canStepQuads();

/// Copies the body's state, and what else has changed, into body.quads, which must be set. Allocates at the
/// first call only. `contacts` must outlive the result; nullptr for a body that is stepped part by part.
kernel::QuadBody loadQuads(SteppedBody& body, const kernel::ContactCalls* contacts);

/// Copies positions and velocities back.
void unloadQuads(SteppedBody& body);

/// The points as they are while they are stepped.
PointView viewOf(QuadArrays& quads);

/// As stepVerlet for a body without links and elastic limit, to the bit. body.quads must be set. Allocates at
/// the first call only.
void stepQuads(SteppedBody& body, double tick, int substeps);

}  // namespace limber
