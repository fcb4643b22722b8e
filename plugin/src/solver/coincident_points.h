// SPDX-License-Identifier: Zlib
#pragma once

#include "solver/point_state.h"
#include "solver/spring_arrays.h"

namespace limber {

/// Moves the ends of springs that lie in one place, though the spring has a length, apart by a millionth of
/// it, each pair in a direction of its own. Without that a spring has no direction to push in, and a body
/// crushed to a point would never unfold. The centre of mass stays; held points do not move.
void separateCoincident(const SpringArrays& springs, PointState& state);

}  // namespace limber
