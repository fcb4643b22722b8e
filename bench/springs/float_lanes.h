// SPDX-License-Identifier: Zlib
#pragma once

#include "solver/lane_kernels.h"

#include <vector>

namespace limber::bench {

/// The kernel that Limber runs on doubles, on floats: only to know what they would save. As many bodies as a
/// register has floats, one per lane.
struct FloatLanes {
  unsigned points = 0, springs = 0;
  std::vector<unsigned> a, b;
  bool damped = false;
  AlignedNumbers position, velocity, force, earlierForce, acceleration, inverseMass;  // as floats
  AlignedNumbers restLength, stiffness, dampHalf, dampFull, direction;
};

#if defined(LIMBER_HAS_LANES)
void stepFloatsSse2(FloatLanes& lanes, double tick, int substeps);
void stepFloatsAvx2(FloatLanes& lanes, double tick, int substeps);
void stepFloatsAvx512(FloatLanes& lanes, double tick, int substeps);
#endif

}  // namespace limber::bench
