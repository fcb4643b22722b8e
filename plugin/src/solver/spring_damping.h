// SPDX-License-Identifier: Zlib
#pragma once

#include "solver/point_state.h"
#include "solver/spring_arrays.h"

namespace limber {

/// exp(-z) for z >= 0 as the reciprocal of exp's Taylor polynomial of degree 4: in (0, 1], falling, error
/// z^5/120. Not std::exp, whose last bits differ between machines.
inline double decay(double z) {
  return 1.0 / (1.0 + z * (1.0 + z / 2.0 * (1.0 + z / 3.0 * (1.0 + z / 4.0))));
}

/// kg: what a damper's impulse is per closing speed over the time dt.
///
/// Along the spring the relative velocity u of two ends with inverse masses wa, wb obeys
///     du/dt = -c (wa + wb) u,   so   u(dt) = u(0) exp(-c (wa + wb) dt),
/// which the impulse J = u (1 - exp(...)) / (wa + wb) on either end brings about exactly.
/// It only ever takes speed away, so damping cannot make the step unstable.
inline double dampingImpulse(double damping, double inverseMasses, double dt) {
  if (inverseMasses == 0.0) return 0.0;
  return (1.0 - decay(damping * inverseMasses * dt)) / inverseMasses;
}

/// Fills dampHalf and dampFull for substeps of `dt` seconds, unless they hold for it already. Where a point
/// moves along some axes only, its largest inverse mass is taken: the damper then brakes a little less, never
/// too much.
void prepareDampers(SpringArrays& springs, const Points& inverseMass, double dt);

enum class SweepOrder { Forward, Backward };

/// Applies each damper's impulse in turn to `state.velocity`, with the given kg per closing speed (dampHalf
/// or dampFull). Alternating the order makes the splitting symmetric, hence second order.
void dampSprings(SpringArrays& springs, const std::vector<double>& impulse, SweepOrder order,
                 PointState& state);

}  // namespace limber
