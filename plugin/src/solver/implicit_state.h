// SPDX-License-Identifier: Zlib
#pragma once

#include "solver/midpoint_contacts.h"
#include "solver/midpoint_solver.h"

namespace limber {

/// What stepImplicit keeps of a body from substep to substep.
struct ImplicitState {
  MidpointSolver solver;
  MidpointContacts contacts;
  Points start, startVelocity;  ///< 3 x #points, m and m/s, at the start of the substep
  Points damperDirection;       ///< 3 x #springs, unit vectors or 0
  Points residual, trial;       ///< 3 x #points, scratch
  double energyFloor = 0.0;     ///< J, the least energy it has had, work done on it and other changes added
  double energyAtEnd = 0.0;     ///< J, at the end of the last tick
  Points meanAcceleration;      ///< 3 x #points, m/s^2, of the last substep
  double remainder = 0.0;       ///< m, what further iterations would move
  double meanOver = 0.0;        ///< s, how long that was; 0: none, or the body has moved otherwise since
};

}  // namespace limber
