// SPDX-License-Identifier: Zlib
#pragma once

// The springs of a body: their constants and order, their forces, with elastic limits, and their dampers.

#include "solver/point_state.h"
#include "solver/shared_constants.h"
#include "solver/verlet_kernel.h"

#include <limber/soft_body_settings.h>
#include <limber/spring_network.h>

#include <cstdint>
#include <memory>
#include <vector>

namespace limber {

/// The constants of springs, one entry per spring of a network, in the order of orderApart().
struct SpringConstants {
  std::vector<std::uint32_t> a, b;           ///< point indices
  std::vector<double> restLength;            ///< m
  std::vector<double> extensionStiffness;    ///< N/m while longer than restLength
  std::vector<double> compressionStiffness;  ///< N/m while shorter
  std::vector<double> damping;               ///< N s/m
  bool damped = false;                       ///< whether any spring has damping

  double shortest = 0.0;  ///< m, the smallest rest length above 0

  ElasticLimit limit;
  bool limited = false;  ///< whether any part of `limit` is on
};

/// The springs of one body. `->` leads to their present constants.
struct SpringArrays {
  SharedConstants<SpringConstants> original;  ///< of all bodies with this network, scale and material
  std::shared_ptr<SpringConstants> yielded;   ///< the body's own ones, from the first tick of a body with an
                                              ///< elastic limit on
  std::size_t broken = 0;                     ///< springs that have broken so far

  // Written by the step; empty until used.
  Points direction;              ///< 3 x #springs, unit vector from a to b, 0 while the spring is slack
  std::vector<double> dampHalf;  ///< kg, impulse per closing speed over half a substep
  std::vector<double> dampFull;  ///< the same over a whole one
  double damperTime = 0.0;       ///< s, the substep they hold for; 0 when an inverse mass has changed since
  unsigned revision = 1;         ///< counts the changes of constants, dampers and inverse masses

  const SpringConstants* operator->() const { return yielded ? yielded.get() : &*original; }
  std::size_t size() const { return original->a.size(); }
};

/// The springs of a body with these settings. Rest lengths are those of the rest points times the scale.
SpringArrays makeSprings(const SpringNetwork& network, const SoftBodySettings& settings);

/// An order of the network's springs in which, as far as it can be, no two of each four in a row (0 to 3, 4
/// to 7, ...) share a point: their dampers can then be computed at once. Neighbours stay near each other.
std::vector<std::uint32_t> orderApart(const SpringNetwork& network);

/// Moves the ends of springs that lie in one place, though the spring has a length, apart by a millionth of
/// it, each pair in a direction of its own. Without that a spring has no direction to push in, and a body
/// crushed to a point would never unfold. The centre of mass stays; held points do not move.
void separateCoincident(const SpringArrays& springs, PointState& state);

// --- as verlet_kernel.h takes them ------------------------------------------------------------------------

/// The arrays of one body.
inline kernel::Springs<double> kernelSprings(SpringArrays& s) {
  if (s.direction.cols() == 0) s.direction.setZero(3, static_cast<Eigen::Index>(s.size()));
  return {static_cast<kernel::Index>(s.size()),
          s->a.data(),
          s->b.data(),
          s->restLength.data(),
          s->extensionStiffness.data(),
          s->compressionStiffness.data(),
          s.direction.data()};
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

/// The force and direction of a spring whose ends are `d` apart (from a to b).
struct SpringPull {
  Eigen::Vector3d direction;  ///< unit vector, or 0 when the spring is slack or its ends coincide
  double force;               ///< N, above 0 pulls the ends together
};

/// Hooke's law with a constant for either side:  F = kE (|d| - L) if |d| > L, else kC (|d| - L).
/// A side without stiffness is slack. Coincident ends have no direction and so no force.
inline SpringPull springPull(const Eigen::Vector3d& d, double restLength, double extension,
                             double compression) {
  const kernel::Pull<double> pull = kernel::pullOf(d.squaredNorm(), restLength, extension, compression);
  return {d * pull.scale, pull.scale > 0.0 ? pull.force : 0.0};
}

/// Sets `state.force` to the force of all springs and keeps their directions for the dampers.
void computeSpringForces(SpringArrays& springs, PointState& state);

/// J, of all springs at the present positions.
double elasticEnergy(const SpringArrays& springs, const Points& position);

// --- dampers -----------------------------------------------------------------------------------------------

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

/// 1/kg: how easily the ends of spring s are moved against each other. Where a point moves along some axes
/// only, its largest inverse mass is taken.
inline double inverseMassesOf(const SpringArrays& springs, const Points& inverseMass, std::size_t s) {
  return inverseMass.col(springs->a[s]).maxCoeff() + inverseMass.col(springs->b[s]).maxCoeff();
}

/// kg: what a damper's impulse is per closing speed over half a substep and a whole one.
struct DampingImpulses {
  double half, full;
};

/// Of spring s, for substeps of dt seconds. Where a point moves along some axes only, the damper brakes a
/// little less, never too much.
inline DampingImpulses dampingImpulses(const SpringArrays& springs, const Points& inverseMass, std::size_t s,
                                       double dt) {
  const double w = inverseMassesOf(springs, inverseMass, s), damping = springs->damping[s];
  return {dampingImpulse(damping, w, 0.5 * dt), dampingImpulse(damping, w, dt)};
}

/// Fills dampHalf and dampFull for substeps of `dt` seconds, unless they hold for it already.
void prepareDampers(SpringArrays& springs, const Points& inverseMass, double dt);

enum class SweepOrder { Forward, Backward };

/// Applies each damper's impulse in turn to `state.velocity`, with the given kg per closing speed (dampHalf
/// or dampFull). Alternating the order makes the splitting symmetric, hence second order.
void dampSprings(SpringArrays& springs, const std::vector<double>& impulse, SweepOrder order,
                 PointState& state);

}  // namespace limber
