// SPDX-License-Identifier: Zlib
#pragma once

#include "core/point_state.h"
#include "core/spring_arrays.h"

#include <limber/soft_body_settings.h>

#include <vector>

namespace limber {

/// rad^2/s^2: no oscillation of these springs is faster, at any deformation.
///
/// The squared frequencies of M^-1 K are those of the matrix  A_st = +-k_t sum_(i in s and t) w_i  over pairs
/// of springs s, t (3 x 3 blocks k_t I bound the stiffness of a spring in all directions while stretched).
/// Gershgorin's row sums of A give  omega^2 <= max_s (w_a S_a + w_b S_b)  with S_i the sum of k at point i.
/// `stiffnessSums` is scratch, resized to #points.
double frequencyBoundSquared(const SpringArrays& springs, const Points& inverseMass,
                             std::vector<double>& stiffnessSums);

/// Substeps for a tick of `tick` seconds: at least settings.atLeast; stable (velocity Verlet: omega dt < 2,
/// the dampers do not change that); period error of the fastest oscillation, (omega dt)^2 / 24 (Hairer,
/// Lubich, Wanner 2006, section I.5), at most settings.periodTolerance.
int substepCount(double frequencySquared, double tick, const Stepping& settings);

}  // namespace limber
