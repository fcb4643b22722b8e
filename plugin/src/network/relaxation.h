// SPDX-License-Identifier: Zlib
// Declares bodies of a network that move without a world: their terms of energy, how they come to rest after
// large deformations, the time steps that they take and the weight that they carry.
#pragma once

#include "solver/point_state.h"
#include "solver/verlet_step.h"

#include <limber/network_analysis.h>
#include <limber/network_builder.h>
#include <limber/soft_body_settings.h>
#include <limber/spring_network.h>

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

namespace limber {

/// All that gives a body its shape back: springs, and the volume of its closed surfaces or its tetrahedra.
struct BodyTerms {
  SpringArrays springs;
  VolumeArrays volumes;           ///< may be empty
  TetrahedronVolumes tetrahedra;  ///< may be empty

  BodyTerms() = default;
  BodyTerms(const SpringNetwork& network, const SoftBodySettings& settings);
};

/// With pointers to `terms` and `state`.
SolverBody solverBody(BodyTerms& terms, PointState& state);

/// rad^2/s^2: no oscillation about these positions is faster.
double boundSquared(BodyTerms& terms, const PointState& state);

/// The points of a body of the settings' scale and mass, at rest about the network's origin.
PointState restState(const SpringNetwork& network, const SoftBodySettings& settings);

/// A body of a network as relaxations see it: of size 1, unit masses, each spring's constant its
/// stiffnessScale, with the volume term that a body of it has by default.
struct RelaxedBody {
  Points rest;  ///< the rest points over the size
  BodyTerms terms;
  std::vector<std::vector<Eigen::Index>> pieces;  ///< points that springs hold together

  explicit RelaxedBody(const SpringNetwork& network);
};

/// A run whose distanceToRest() is below this has returned.
constexpr double kReturned = 1e-3;

/// Root mean square distance of the points to the rest points after the best rigid motion of each piece,
/// without reflection (Kabsch 1976).
double distanceToRest(const RelaxedBody& body, const Points& x);

/// Relaxes `count` starts. `start(i)` gives the positions that run i is let go from, at rest; `finish(i, x)`
/// takes those it has come to rest at, in any order, and returns false to end early.
///
/// Each run is lightly damped dynamics (drag of 0.05 per unit mass and second at unit spring constants) until
/// nearly all kinetic energy is gone, then descent to the minimum of the energy. What run i ends in depends
/// on its start alone.
void relax(RelaxedBody& body, std::size_t count, const std::function<Points(std::size_t)>& start,
           const std::function<bool(std::size_t, const Points&)>& finish);

/// Whether the steps that the body's fastest oscillation allows lead anywhere in a time that is worth waiting
/// for. If not, relax() ends, but where it ends in says nothing about the body.
bool canRelax(RelaxedBody& body);

/// The rest points after run `run` of this kind of deformation, in a direction, and with a point, that
/// depend on (kind, seed, run) alone. Every point is moved by up to a further 1e-4 of the size, so that a
/// body is never exactly in an unstable equilibrium.
Points deform(const Points& rest, Deformation kind, std::uint64_t seed, std::uint64_t run);

/// Never the seed itself: a network that was braced against the deformations of a seed must not be measured
/// on the same ones.
std::uint64_t measuringSeed(std::uint64_t seed);

/// Lets the network go from `runs` seeded deformations of this kind, lightly damped, with the volume term a
/// body of it would have, and counts those that come back. Run i depends on (kind, seed, i) alone. `progress`
/// may be empty; when it returns false the runs done so far are returned. No runs where they would say
/// nothing, see canRelax().
/// The seed of the deformations is measuringSeed(seed).
ReturnRate measureReturns(const SpringNetwork& network, Deformation kind, std::uint32_t runs,
                          std::uint64_t seed, const Progress& progress = {});

/// Substeps of velocity Verlet; dampers do not change them, see verlet_step.h.
struct TimeSteps {
  double critical =
      0.0;            ///< s: 2 / omega of the stiffest oscillation about the rest shape. Longer ones blow up
  double safe = 0.0;  ///< s: from Gershgorin's bound of omega, which holds at any deformation of the springs;
                      ///< the volume terms' part is that at rest
};

/// Of a body with the settings' masses, stiffness, scale and volume modulus; infinite where nothing is stiff.
TimeSteps timeSteps(const SpringNetwork& network, const SoftBodySettings& settings);

/// The spring constant (N/m) below which a body collapses under its own weight. It is put down as it is
/// modelled, with its lowest point on a rough floor, gravity along -y and without speed, sinks until it
/// rests, and is then relieved of its weight. It carries itself if it stands half as high as it is and
/// springs back to its shape afterwards. To about 4 %; infinite for bodies that collapse however stiff they
/// are, 0 without gravity or springs.
///
/// In units of the size L, the mean mass m of a point and the stiffness k a body has nothing but the load
/// m g / (k L), and the smallest load that is too much is what is searched for. Of the settings counts what
/// shapes these units (total mass, scale, stiffness) and the volume modulus, whose ratio to the stiffness is
/// kept. `gravity` in m/s^2.
///
/// Pieces that no spring joins are put down one by one, and the one that needs most counts. Nothing when
/// `progress` (may be empty) asks for an early end, or when the body's fastest oscillation is so fast against
/// its slow ones that following it to rest would take too many steps.
std::optional<double> leastStiffness(const SpringNetwork& network, const SoftBodySettings& settings,
                                     double gravity, const Progress& progress = {});

}  // namespace limber
