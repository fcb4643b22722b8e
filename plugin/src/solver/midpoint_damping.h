// SPDX-License-Identifier: Zlib
#pragma once

#include "solver/point_state.h"
#include "solver/springs.h"

namespace limber {

/// How far towards the end of a substep a damper looks, 0 to 1. The implicit midpoint rule would take the
/// mean velocity v_m, which leaves overdamped motion ringing: with z = c (wa + wb) h it multiplies the
/// closing speed by (1 - z/2) / (1 + z/2), close to -1. With v_m + beta (v_m - v0) instead it becomes
///     (1 - z (1 - beta) / 2) / (1 + z (1 + beta) / 2),
/// and beta = z / (2 + z) keeps second order for small z and lets the speed die out for large.
inline double lookAhead(double damping, double inverseMasses, double h) {
  const double z = damping * inverseMasses * h;
  return z / (2.0 + z);
}

/// kg: what the damper of spring s adds to the matrix of the midpoint rule, h/2 c (1 + beta).
inline double dampingWeight(const SpringArrays& springs, const Points& inverseMass, std::size_t s, double h) {
  const double c = springs.damping[s];
  return 0.5 * h * c * (1.0 + lookAhead(c, inverseMassesOf(springs, inverseMass, s), h));
}

}  // namespace limber
