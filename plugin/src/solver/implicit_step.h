// SPDX-License-Identifier: Zlib
#pragma once

#include "solver/implicit_state.h"
#include "solver/verlet_step.h"

namespace limber {

/// Whether stepImplicit can step the body: points are held along all axes or none, no elastic limit, not more
/// contacts than it solves, and none with a moving surface.
bool canStepImplicitly(const SteppedBody& body);

/// Advances one body without links by `tick` seconds in `substeps` substeps of h of the implicit midpoint
/// rule
///
///     x1 = x0 + h v_m,   v1 = v0 + h (a + M^-1 f(x_m)),   x_m = (x0 + x1) / 2,   v_m = (v0 + v1) / 2,
///
/// solved for x_m by iterating  x_m += A^-1 (M (y - x_m) + h^2/4 f(x_m)),  y = x0 + h/2 v0 + h^2/4 a,  with
/// the matrix of either kind (midpoint_solver.h): local/global iterations (Liu and others 2013; Dinev and
/// others 2018 for the midpoint rule) or Newton's method. Second order; linear momentum is exact at every
/// iteration, angular momentum when converged. Where rounding of the iterations or the nonlinearity would add
/// energy, it is taken out of the internal motion (removeKineticEnergy). Allocates when the body, its springs or h
/// are new.
void stepImplicit(SteppedBody& body, ImplicitState& implicit, MidpointSolver::Kind kind, double tick,
                  int substeps, SharedFactors& factors);

}  // namespace limber
