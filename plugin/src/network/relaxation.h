// SPDX-License-Identifier: Zlib
// Declares bodies of a network that move outside a world: their energy terms, their large deformations and
// their relaxation.
#pragma once

#include "solver/verlet_step.h"

#include <limber/network_builder.h>

#include <cstdint>
#include <functional>
#include <limits>
#include <vector>

namespace limber {

/// The terms that restore the shape of a body: springs, and the volume of its closed surfaces or its
/// tetrahedra.
struct BodyTerms {
  SpringArrays springs;
  VolumeArrays volumes;           ///< may be empty
  TetrahedronVolumes tetrahedra;  ///< may be empty

  BodyTerms() = default;
  BodyTerms(const SpringNetwork& network, const SoftBodySettings& settings);
};

/// Returns a body with pointers to `terms` and `state`.
SolverBody solverBody(BodyTerms& terms, PointState& state);

/// Returns an upper bound (rad^2/s^2) of the squared frequencies of all oscillations about these positions.
double boundSquared(BodyTerms& terms, const PointState& state);

/// Returns the points of a body of the settings' scale and mass, at rest about the network's origin.
PointState restState(const SpringNetwork& network, const SoftBodySettings& settings);

/// A body of a network for relaxations: of size 1, with unit masses. The constant of each spring is its
/// stiffnessScale. The volume term is that of a body with default settings.
struct RelaxedBody {
  Points rest;  ///< the rest points over the size
  BodyTerms terms;
  std::vector<std::vector<std::uint32_t>> pieces;  ///< points that springs connect

  explicit RelaxedBody(const SpringNetwork& network);
};

/// A run with a distanceToRest() below this has returned.
constexpr double kReturned = 1e-3;

/// Returns the root mean square distance of the points from the rest points after the best rigid motion of
/// each piece, without reflection (Kabsch 1976).
double distanceToRest(const RelaxedBody& body, const Points& x);

/// For relax(): all starts are wanted.
constexpr std::size_t kAllStarts = std::numeric_limits<std::size_t>::max();

/// Relaxes `count` starts. `start(i)` returns the positions from which run i is released without velocity.
/// `finish(i, x)` is called with the positions at which it came to rest, in any order. It returns how many of
/// the starts are still wanted, 0 to kAllStarts: runs from that number on are dropped.
///
/// Each run is lightly damped dynamics (drag of 0.05 per unit mass and second at unit spring constants) until
/// nearly all kinetic energy is gone, then a descent to the minimum of the energy. The result of run i
/// depends on its start alone. With `parallel`, `start` and `finish` are called on several threads at a time.
void relax(RelaxedBody& body, std::size_t count, const std::function<Points(std::size_t)>& start,
           const std::function<std::size_t(std::size_t, const Points&)>& finish,
           const ParallelFor& parallel = {});

/// Returns whether relax() can reach results in acceptable time with the steps that the body's fastest
/// oscillation allows. If not, relax() ends, but its results are meaningless.
bool canRelax(RelaxedBody& body);

/// Returns the rest points after deformation `run` of this kind. Its direction and its point depend on (kind,
/// seed, run) alone. Every point is moved by up to a further 1e-4 of the size, so that a body is never
/// exactly in an unstable equilibrium.
Points deform(const Points& rest, Deformation kind, std::uint64_t seed, std::uint64_t run);

}  // namespace limber
