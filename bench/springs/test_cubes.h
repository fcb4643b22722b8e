// SPDX-License-Identifier: Zlib
#pragma once

#include "solver/simd_steps.h"

#include <deque>
#include <functional>

namespace limber::bench {

/// Cubes of 8 points and 28 springs that breathe and turn.
struct TestCube {
  PointState state;
  SpringArrays springs;
  std::vector<PlaneContact> contacts;
  SpringBatchArrays springBatches;
  SolverIsland group;
};

/// `count` cubes at their start, which may share lanes; `resting` gives each the four contacts of one that
/// lies on a floor.
std::deque<TestCube> makeCubes(int count, double damping, bool resting);

}  // namespace limber::bench
