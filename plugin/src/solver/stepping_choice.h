// SPDX-License-Identifier: Zlib
#pragma once

// How fast a body oscillates, and the stepper and number of substeps that this asks for.

#include "solver/point_state.h"
#include "solver/springs.h"
#include "solver/volumes.h"

#include <limber/soft_body_settings.h>

#include <vector>

namespace limber {

// --- the fastest oscillation -------------------------------------------------------------------------------

/// rad^2/s^2: the largest eigenvalue of M^-1/2 K M^-1/2, K being the stiffness matrix at the state's
/// positions: the square of the stiffest of the oscillations about them. Springs count with the larger of
/// their two constants, and stiffen across their direction when they are stretched. Too small by about the
/// square of `tolerance`; 0.03 takes some 16 products with K.
double fastestOscillationSquared(const SpringArrays& springs, const VolumeArrays& volumes,
                                 const TetrahedronVolumes& tetrahedra, const PointState& state,
                                 double tolerance);

// --- the choice --------------------------------------------------------------------------------------------

/// rad^2/s^2: no oscillation of these springs is faster, at any deformation.
///
/// The squared frequencies of M^-1 K are those of the matrix  A_st = +-k_t sum_(i in s and t) w_i  over pairs
/// of springs s, t (3 x 3 blocks k_t I bound the stiffness of a spring in all directions while stretched).
/// Gershgorin's row sums of A give  omega^2 <= max_s (w_a S_a + w_b S_b)  with S_i the sum of k at point i.
/// `stiffnessSums` is scratch, resized to #points.
double frequencyBoundSquared(const SpringArrays& springs, const Points& inverseMass,
                             std::vector<double>& stiffnessSums);

/// How fast a body may oscillate, rad^2/s^2.
struct Frequencies {
  double boundSquared = 0.0;    ///< at any deformation, see frequencyBoundSquared
  double fastestSquared = 0.0;  ///< about its rest shape, see fastestOscillationSquared
};

/// Substeps for a tick of `tick` seconds: at least settings.minSubsteps; stable at any deformation (velocity
/// Verlet: omega dt < 2, the dampers do not change that); period error of the fastest oscillation about the
/// rest shape, (omega dt)^2 / 24 (Hairer, Lubich, Wanner 2006, section I.5), at most
/// settings.periodTolerance.
int substepCount(const Frequencies& frequencies, double tick, const Stepping& settings);

/// What the choice of a stepper for one tick of one group depends on.
struct SteppingProblem {
  Frequencies frequencies;
  double dampingRate = 0.0;       ///< 1/s, dampingRateBound
  double turnRate = 0.0;          ///< rad/s, fastestTurn
  double tick = 0.0;              ///< s
  double errorCoefficient = 0.0;  ///< m/s^3, the last error rate over the square of its substep; 0: unknown
  double size = 0.0;              ///< m, of the body
  bool implicitPossible = false;  ///< see canStepImplicitly
  bool touching = false;          ///< has contacts
  bool cheapNewton =
      false;            ///< a few points, or few diagonals: the banded matrix is factorised in microseconds
  bool narrow = false;  ///< a rope or chain: the banded matrix has a few diagonals only
  bool held = false;    ///< some points are pinned
};

struct SteppingChoice {
  Stepper stepper = Stepper::Verlet;
  int substeps = 1;
  bool cut = false;  ///< the budget allows fewer than are needed
};

/// 1/s: the fastest a damper of these springs takes speed away, max c (wa + wb).
double dampingRateBound(const SpringArrays& springs, const Points& inverseMass);

/// rad/s: the fastest turning of a spring, its ends' relative velocity over its length; 0 if it is surely
/// below `negligible`.
double fastestTurn(const SpringArrays& springs, const PointState& state, double negligible);

/// The stepper and its substeps for this tick:
///   - Verlet, in as many substeps as are stable, keep periodTolerance, and resolve the fastest turning;
///   - Newton's method for a body damped so strongly that splitting the dampers off would slow its creep, if
///   that
///     is cheap; large meshes stay with Verlet;
///   - where so many substeps are needed to be stable that implicit ones are cheaper, for bodies in free
///   motion,
///     Newton's method for ropes and chains and local/global iterations for all others, unless a
///     periodTolerance below the usual one is asked for;
///   - one of these too when the budget does not allow Verlet its stable number.
/// A tolerance raises the number of substeps, the budget caps it. A forced stepper is taken where possible.
SteppingChoice chooseStepping(const SteppingProblem& problem, const Stepping& settings);

}  // namespace limber
