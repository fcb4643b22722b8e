// SPDX-License-Identifier: Zlib
#pragma once

// The frequencies at which a body oscillates, the stepper and number of substeps that these require, and
// softer constants for bodies whose budget of substeps does not resolve their stiffness.

#include "solver/volumes.h"

#include <memory>
#include <vector>

namespace limber {

// --- the fastest oscillation -------------------------------------------------------------------------------

/// Returns the largest eigenvalue (rad^2/s^2) of M^-1/2 K M^-1/2, with the stiffness matrix K at the state's
/// positions: the square of the fastest oscillation about them. Springs count with the larger of their two
/// constants, and stiffen across their direction when stretched. The result is too small by about the square
/// of `tolerance`; 0.03 takes about 16 products with K.
double fastestOscillationSquared(const SpringArrays& springs, const VolumeArrays& volumes,
                                 const TetrahedronVolumes& tetrahedra, const PointState& state,
                                 double tolerance);

// --- the choice --------------------------------------------------------------------------------------------

/// Returns an upper bound (rad^2/s^2) of the oscillations of these springs at any deformation.
///
/// The squared frequencies of M^-1 K are those of the matrix  A_st = +-k_t sum_(i in s and t) w_i  over pairs
/// of springs s, t (3 x 3 blocks k_t I bound the stiffness of a spring in all directions while stretched).
/// Gershgorin's row sums of A give  omega^2 <= max_s (w_a S_a + w_b S_b)  with S_i the sum of k at point i.
/// `stiffnessSums` is scratch, resized to #points.
double frequencyBoundSquared(const SpringArrays& springs, const Points& inverseMass,
                             std::vector<double>& stiffnessSums);

/// Frequencies of a body's oscillations, rad^2/s^2.
struct Frequencies {
  double boundSquared = 0.0;    ///< at any deformation, see frequencyBoundSquared
  double fastestSquared = 0.0;  ///< about its rest shape, see fastestOscillationSquared
};

/// Returns the number of substeps for a tick of `tick` seconds: at least settings.minSubsteps; stable at any
/// deformation (velocity Verlet: omega dt < 2, also with dampers); period error of the fastest oscillation
/// about the rest shape, (omega dt)^2 / 24 (Hairer, Lubich, Wanner 2006, section I.5), at most
/// settings.periodTolerance.
int substepCount(const Frequencies& frequencies, double tick, const Stepping& settings);

/// The data for the choice of a stepper for one tick of one island.
struct SteppingProblem {
  Frequencies frequencies;
  double dampingRate = 0.0;       ///< 1/s, dampingRateBound
  double turnRate = 0.0;          ///< rad/s, fastestTurn
  double impactSpeed = 0.0;       ///< m/s, at which touching bodies approach each other or change their shape
  double tick = 0.0;              ///< s
  double errorCoefficient = 0.0;  ///< m/s^3, the last error rate over the square of its substep; 0: unknown
  double size = 0.0;              ///< m, of the body
  bool implicitPossible = false;  ///< see canStepImplicitly
  bool touching = false;          ///< has contacts
  bool cheapNewton = false;       ///< few points or few diagonals: the matrix is factorised in microseconds
  bool narrow = false;            ///< a rope or chain: the factors of its matrix have few blocks
  bool held = false;              ///< some points are pinned
};

/// Largest number of substeps per tick, also in validate(SoftBodySettings). Springs that would need more, as
/// those of 1e12 N/m on a gram, do not oscillate visibly.
constexpr int kMaxSubsteps = 10000;

struct SteppingChoice {
  Stepper stepper = Stepper::Verlet;
  int substeps = 1;
  bool cut = false;  ///< maxSubsteps allows fewer than are needed
};

/// Returns the largest rate (1/s) at which a damper of these springs reduces a speed, max c (wa + wb).
double dampingRateBound(const SpringArrays& springs, const Points& inverseMass);

/// Returns the rate (rad/s) of a rotation that needs no more substeps than usual in ticks of `tick` seconds.
double negligibleTurn(double fastestSquared, double tick);

/// Returns the fastest rotation (rad/s) of a spring: the relative velocity of its ends across it over its
/// length; 0 if it is surely below `negligible`. `fastest`: m/s, the largest velocity of a point relative to
/// any common one.
double fastestTurn(const SpringArrays& springs, const PointState& state, double fastest, double negligible);

/// Chooses the stepper and its substeps for this tick:
///   - Verlet, with enough substeps for stability, periodTolerance, the fastest rotation of a spring and
///     impacts of strongly damped bodies;
///   - Newton's method, if it is cheap, for damping so strong that splitting it off would slow the creep;
///     large meshes stay with Verlet;
///   - an implicit stepper, where the stable number of substeps costs more, for bodies in free motion:
///     Newton's method for ropes and chains, local/global iterations for all others; not with a
///     periodTolerance below the default;
///   - Verlet instead of any implicit stepper for a touching body that would need very many of its substeps;
/// A tolerance raises the number of substeps, maxSubsteps limits it, even below Verlet's stable number: see
/// softened(). A stepper that the user has set is used where possible.
SteppingChoice chooseStepping(const SteppingProblem& problem, const Stepping& settings);

// --- softer constants --------------------------------------------------------------------------------------

/// The elastic constants of a body.
struct ElasticConstants {
  SharedConstants<SpringConstants> springs;
  SharedConstants<VolumeConstants> volumes;
  SharedConstants<TetrahedronConstants> tetrahedra;
};

/// Elastic constants that Verlet's substeps resolve, and what they were made from.
struct SoftenedConstants {
  ElasticConstants constants;
  double share = 1.0;    ///< smallest share of a spring's stiffness, or of a volume modulus, that is left
  double largest = 0.0;  ///< rad^2/s^2, see softened()
  Points inverseMass;    ///< 3 x #points, 1/kg
};

/// Returns constants with which the square of the body's fastest oscillation about its rest shape is at most
/// `largest` (rad^2/s^2), and that of its springs at any deformation.
///
/// The bounds of springs, closed surfaces and tetrahedra add up. Those that are small beside `largest` keep
/// their stiffness, the others are softened in proportion: moduli and pressures, also the ambient one, as a
/// whole; springs one by one, so that those which are slow enough keep theirs. Rest lengths, masses and
/// dampers stay.
SoftenedConstants softened(const ElasticConstants& full, const Points& restShape, const Points& inverseMass,
                           double largest);

/// The softened constants of bodies of one model. Bodies with equal masses and limits share them, so that
/// they can be stepped in SIMD lanes.
using SharedSoftening = SharedObjects<SoftenedConstants>;
std::shared_ptr<const SoftenedConstants> softened(SharedSoftening& shared, const ElasticConstants& full,
                                                  const Points& restShape, const Points& inverseMass,
                                                  double largest);

}  // namespace limber
