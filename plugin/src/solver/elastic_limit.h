// SPDX-License-Identifier: Zlib
#pragma once

#include "solver/point_state.h"
#include "solver/spring_arrays.h"

namespace limber {

/// addSpringForces for springs with an elastic limit, which first lets them yield and break. With L0 the rest
/// length the spring was made with, L the present one, l its length and e = l - L:
///
///     breaks    when l - L0 > breakStrain L0: no force, no damping from then on
///     yields    when |e| > yieldStrain L0: L moves until |e| is that, but not beyond L0 (1 +- yieldMaximum);
///               rate-independent, so the result does not depend on the substep
///     stiffens  F = k e up to |e| = s = stiffenStrain L0, then k (s + stiffenFactor (|e| - s)), signed
void addLimitedForces(SpringArrays& springs, PointState& state);

/// J at elongation e (m) of a spring of stiffness k that stiffens beyond |e| = s by the factor.
double stiffenedEnergy(double k, double e, double s, double factor);

}  // namespace limber
