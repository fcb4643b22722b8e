// SPDX-License-Identifier: Zlib
#pragma once

#include "solver/verlet_step.h"

#include <limber/soft_body_settings.h>
#include <limber/spring_network.h>

namespace limber {

/// All that gives a body its shape back: springs, and the volume of its closed surfaces or its tetrahedra.
struct BodyTerms {
  SpringArrays springs;
  VolumeArrays volumes;           ///< may be empty
  TetrahedronVolumes tetrahedra;  ///< may be empty

  BodyTerms() = default;
  BodyTerms(const SpringNetwork& network, const SoftBodySettings& settings);
};

/// With pointers to `terms` and `state`.
SteppedBody steppedBody(BodyTerms& terms, PointState& state);

/// rad^2/s^2 that the volume terms can add to the square of the fastest oscillation in the next `time`
/// seconds.
double volumeBoundSquared(BodyTerms& terms, const PointState& state, double time);

/// rad^2/s^2: no oscillation about these positions is faster.
double boundSquared(BodyTerms& terms, const PointState& state);

}  // namespace limber
