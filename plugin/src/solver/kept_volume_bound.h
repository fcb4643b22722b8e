// SPDX-License-Identifier: Zlib
#pragma once

#include "solver/volume_term.h"

namespace limber {

/// As volumeFrequencyBoundSquared(), which costs about as much as a substep: its last value for as long as
/// the body keeps its shape, for which that was made a little larger. `kept.value` has to be set to 0 when
/// masses change.
double keptVolumeBoundSquared(VolumeArrays& volumes, const PointState& state, double tick);

}  // namespace limber
