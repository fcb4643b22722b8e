// SPDX-License-Identifier: Zlib
#pragma once

#include "solver/verlet_step.h"

#include <functional>

namespace limber {

/// Moves the points to the minimum of the elastic energy that lies downhill, by L-BFGS (Liu and Nocedal
/// 1989), until the largest force on a point is below `leastForce` (N), `arrived` says so of the positions,
/// or after `iterations`.
void descend(SteppedBody& body, double leastForce, std::size_t iterations,
             const std::function<bool(const Points&)>& arrived);

}  // namespace limber
