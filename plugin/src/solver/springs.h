// SPDX-License-Identifier: Zlib

// The springs of a body: their order and division among threads, constants, forces, elastic limits and
// dampers.

#pragma once

#include "solver/point_state.h"
#include "solver/verlet_kernel.h"

#include <limber/soft_body_settings.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace limber {

/// Consecutive springs or tetrahedra, in the order in which a body computes them.
struct Range {
  std::uint32_t begin, end;
};

/// The springs of a regular network, such as a grid of cloth or a lattice, in batches of four that need no
/// rearrangement in vector registers. The points are cut into four strips of consecutive numbers: point i is
/// at slot i % length of strip i / length. Neighbours in a grid have numbers that differ by the same few
/// numbers everywhere, so in each strip springs connect the same slots. The four springs of a batch go from
/// the slot a, each from another strip, to the slot b of the same strip or of the next one.
struct Strips {
  static constexpr std::uint32_t kCount = 4;

  struct Batch {
    std::uint32_t a, b;   ///< slots, not equal: no two springs of a batch share a point
    std::uint32_t shift;  ///< 0, or 1: to the next strip; then the last spring is missing
  };

  std::uint32_t length = 0;  ///< number of slots; 0: the network is not regular
  std::vector<Batch> batches;
  std::vector<std::uint32_t> places;  ///< #springs, ordered as Division::order: 4 x batch + strip of a's end
};

/// Springs, or tetrahedra, in an order and in ranges for several threads. The phases follow one another. The
/// ranges of a phase share no point, so they can be computed at the same time. Each point gets its forces in
/// the same order with any number of threads. All ranges begin with a batch of the kernel: at a multiple of
/// four, or in `strips`.
struct Division {
  static constexpr std::size_t kPhases = 3;
  std::vector<std::uint32_t> order;  ///< indices in the network
  std::array<std::vector<Range>, kPhases> phases;

  std::vector<std::uint32_t> points;  ///< #points, in the order of the ranges of phase 0; empty if undivided
  std::vector<Range> pointRanges;     ///< of `points`, one for each range of phase 0

  Strips strips;                     ///< of springs
  std::vector<std::uint32_t> slots;  ///< of `strips`, likewise; empty if undivided
  std::vector<Range> slotRanges;     ///< of `slots`, one for each range of phase 0

  bool isDivided() const { return phases[0].size() > 1; }
};

/// Divides the springs of a network of some thousand springs or more; otherwise they are one range. Inside
/// the ranges no two springs of a batch of four (0 to 3, 4 to 7, ...) share a point, where possible, so that
/// the dampers of a batch can be computed at once. Springs that share a point are far apart, so that batches
/// need not wait for each other. The same applies to batches in strips.
Division divideSprings(const SpringNetwork& network);

/// The same for tetrahedra, which stay in the network's order inside a range.
Division divideTetrahedra(const SpringNetwork& network);

/// The constants of the springs of a network: one entry per spring, in the order of `division`.
struct SpringConstants {
  Division division;                         ///< #springs
  std::vector<std::uint32_t> a, b;           ///< point indices
  std::vector<double> restLength;            ///< m
  std::vector<double> extensionStiffness;    ///< N/m while longer than restLength
  std::vector<double> compressionStiffness;  ///< N/m while shorter
  std::vector<double> damping;               ///< N s/m
  std::vector<double> limitFactor;           ///< of the strains of `limit`; empty: 1
  bool damped = false;                       ///< whether any spring has damping

  double shortest = 0.0;  ///< m, smallest rest length above 0

  ElasticLimit limit;
  bool limited = false;  ///< whether any limit of `limit` is enabled
  bool kinked = false;   ///< whether the stiffness of any spring changes with its length
};

/// The springs of one body. `->` accesses their present constants.
struct SpringArrays {
  SharedConstants<SpringConstants> original;  ///< shared by all bodies with this network, scale and material
  std::shared_ptr<SpringConstants> yielded;   ///< this body's own constants; nullptr without elastic limits
                                              ///< and before the first tick
  std::size_t broken = 0;                     ///< number of broken springs

  // Written by the step; empty before the first use.
  Points direction;                  ///< 3 x #springs, unit vector from a to b, 0 while the spring is slack
  std::vector<double> dampHalf;      ///< kg, impulse per closing speed in a sweep of half a substep
  std::vector<double> dampFull;      ///< the same of a whole substep
  std::vector<double> stretch;       ///< m, at the last forces, and
  std::vector<double> crossingLoss;  ///< m/N, see kernel::crossingForce(); both empty unless `kinked`
  int sweeps = 0;            ///< sweeps over the dampers in each substep, see prepareDampers(); 0: no dampers
  bool oneSweep = false;     ///< no more sweeps: fewer substeps than needed are a promise of time
  double preparedFor = 0.0;  ///< s, substep of these; 0 after a change of an inverse mass
  unsigned revision = 1;     ///< counts the changes of constants, dampers and inverse masses

  const SpringConstants* operator->() const { return yielded ? yielded.get() : &*original; }
  std::size_t size() const { return original->a.size(); }
  void allocateDirections() { direction.resize(3, static_cast<Eigen::Index>(size())); }
};

/// The factors of a group apply to its members. Returns the products for all points and springs of a network.
struct GroupFactors {
  std::vector<double> stiffness, damping, limitStrain, restLength;  ///< #springs
  std::vector<double> mass;                                         ///< #points

  GroupFactors(const SpringNetwork& network, const std::vector<GroupSettings>& groups);
};

/// Returns why the settings' groups do not suit the network, or an empty string.
std::string checkGroups(const SpringNetwork& network, const std::vector<GroupSettings>& groups);

/// Makes the springs of a body with these settings. Rest lengths are distances of the scaled rest points.
SpringArrays makeSprings(const SpringNetwork& network, const SoftBodySettings& settings);

/// Moves the coincident ends of each spring apart by a millionth of its rest length, each pair in a different
/// direction. Coincident ends give a spring no direction for its force: a body crushed to a point would never
/// unfold. Does nothing for springs of rest length 0. The centre of mass and held points do not move.
void separateCoincident(const SpringArrays& springs, PointState& state);

/// Returns the length (m) to which the strains of spring i's limits refer.
double limitLength(const SpringArrays& springs, std::size_t i);

/// Takes all stiffness and damping from spring i. The body must have its own constants (`yielded`).
void breakSpring(SpringArrays& springs, std::size_t i);
bool isBroken(const SpringArrays& springs, std::size_t i);

// --- arguments of verlet_kernel.h --------------------------------------------------------------------------

// Arrays that a step writes must be allocated.

inline kernel::Springs<double> kernelSprings(SpringArrays& s) {
  return {static_cast<kernel::Index>(s.size()),
          s->a.data(),
          s->b.data(),
          s->restLength.data(),
          s->extensionStiffness.data(),
          s->compressionStiffness.data(),
          s.direction.data(),
          s.stretch.empty() ? nullptr : s.stretch.data(),
          s.crossingLoss.data()};
}

inline kernel::Points<double> kernelPoints(PointState& p) {
  return {static_cast<kernel::Index>(p.position.cols()),
          p.position.data(),
          p.velocity.data(),
          p.force.data(),
          p.acceleration.data(),
          p.inverseMass.data()};
}

// --- forces ------------------------------------------------------------------------------------------------

/// The force of a spring and its direction.
struct SpringPull {
  Eigen::Vector3d direction;  ///< unit vector, or 0 when the spring is slack or its ends coincide
  double force;               ///< N, positive: pulls the ends together
};

/// Returns the force of a spring by Hooke's law, where `d` (m) is the offset from end a to end b:
///     F = kE (|d| - L) if |d| > L, else kC (|d| - L).
/// The spring is slack where its stiffness is 0. Coincident ends have no direction and so no force.
inline SpringPull springPull(const Eigen::Vector3d& d, double restLength, double extension,
                             double compression) {
  const kernel::Pull<double> pull = kernel::pullOf(d.squaredNorm(), restLength, extension, compression);
  return {d * pull.scale, pull.scale > 0.0 ? pull.force : 0.0};
}

/// Sets `state.force` to the force of all springs and stores their directions for the dampers. `crossing`:
/// the share of kernel::crossingForce(); above 0 only within a step.
void computeSpringForces(SpringArrays& springs, PointState& state, double crossing = kernel::kFirstCrossing);

/// Returns the elastic energy (J) of all springs with the points at `position`.
double elasticEnergy(const SpringArrays& springs, const Points& position);

// --- dampers -----------------------------------------------------------------------------------------------

/// Approximates exp(-z) for z >= 0 by the reciprocal of exp's Taylor polynomial of degree 4. The result is in
/// (0, 1], decreases with z and has an error of z^5/120. std::exp is not used: its last bits differ between
/// machines.
inline double decay(double z) {
  return 1.0 / (1.0 + z * (1.0 + z / 2.0 * (1.0 + z / 3.0 * (1.0 + z / 4.0))));
}

/// Returns the impulse per closing speed (kg) over the time dt of a damper that acts alone.
///
/// Along the spring the relative velocity u of two ends with inverse masses wa, wb obeys
///     du/dt = -c (wa + wb) u,   so   u(dt) = u(0) exp(-c (wa + wb) dt).
/// The impulse J = u (1 - exp(...)) / (wa + wb) on both ends causes exactly this change.
/// It only reduces the speed, so damping cannot make the step unstable.
inline double dampingImpulse(double damping, double inverseMasses, double dt) {
  if (inverseMasses == 0.0) return 0.0;
  return (1.0 - decay(damping * inverseMasses * dt)) / inverseMasses;
}

/// The largest share of a pair's closing speed that a damper of a network takes in a sweep. Up to 2 the
/// energy does not increase; above 1 the closing speed changes its sign.
constexpr double kLargestShare = 1.5;

/// Returns the impulse per closing speed (kg) over the time dt of a damper of a network.
///
/// In a motion whose strain rate is uniform the dampers at a point cancel. A sweep applies them in turn: on
/// average half of the others have pushed the ends apart before, by half the share s = J (wa + wb) / u that
/// this one takes. So it acts with  s (1 + s / 2),  which must be  z = c (wa + wb) dt:   s = sqrt(1 + 2 z)
/// - 1. The share 1 - exp(-z) of a damper alone differs from s by z^3 / 3, and takes too little in a network.
inline double networkDampingImpulse(double damping, double inverseMasses, double dt) {
  if (inverseMasses == 0.0) return 0.0;
  const double share = std::sqrt(1.0 + 2.0 * damping * inverseMasses * dt) - 1.0;
  return std::min(share, kLargestShare) / inverseMasses;
}

/// Returns the sum of the inverse masses (1/kg) of the ends of spring s. For a point that moves along some
/// axes only, it uses the largest inverse mass.
inline double inverseMassesOf(const SpringArrays& springs, const Points& inverseMass, std::size_t s) {
  return inverseMass.col(springs->a[s]).maxCoeff() + inverseMass.col(springs->b[s]).maxCoeff();
}

/// Computes dampHalf, dampFull, sweeps and crossingLoss for substeps of `dt` seconds, unless they are already
/// valid for `dt`. If an end moves along some axes only, impulses may be too small, but never too large.
///
/// One sweep stops pairs whose z = c (wa + wb) dt is large, and slows a motion of the whole body down much
/// less than their dampers should. So the substep is divided into up to 16 sweeps, until the mean z is at
/// most 1.5, unless oneSweep.
void prepareSprings(SpringArrays& springs, const Points& inverseMass, double dt);

/// Sets oneSweep.
void limitSweeps(SpringArrays& springs, bool oneSweep);

}  // namespace limber
