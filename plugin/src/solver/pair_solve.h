// SPDX-License-Identifier: Zlib
#pragma once

#include "solver/pair_contacts.h"

namespace limber {

/// Before a drift of dt seconds in a tick of that length: impulses with which no pair ends nearer than it may,
/// those that overlap draw apart gently, friction stops as much sliding as it can, and joints and anchors
/// hold. From the impulses of the last
/// substep on, by projected Gauss-Seidel sweeps with a nonsmooth nonlinear conjugate gradient step between
/// them (Silcowitz, Niebe, Erleben 2010, algorithm 2). Returns the number of sweeps.
int stopPairs(PairRows& rows, LinkedBodies& bodies, double dt, double tick);

/// After the second kick of a substep: pairs that bore something do not approach, as settleContacts, and the
/// velocities of anchored points are those of their pivots.
int settlePairs(PairRows& rows, LinkedBodies& bodies);

}  // namespace limber
