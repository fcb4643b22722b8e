// SPDX-License-Identifier: Zlib
// Declares the measurements of which analyse() is made.
#pragma once

#include <limber/network_analysis.h>

#include <Eigen/Core>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

namespace limber {

/// Returns a network of these points and the springs, triangles and tetrahedra that join no others. Its mass
/// fractions sum to 1. Its report describes the edge defects of its part of the surface. It has no render
/// surface.
SpringNetwork pieceOf(const SpringNetwork& network, const std::vector<std::uint32_t>& points);

/// Small deformations of a network about its rest shape, with unit masses and without the volume term. The
/// constant of each spring is its stiffnessScale.
struct SmallDeformations {
  std::size_t rank = 0, mechanisms = 0, selfStresses = 0;
  double softest = 0.0,
         stiffest = 0.0;  ///< eigenvalues of the stiffness matrix, without mechanisms and rigid motions
};

SmallDeformations smallDeformations(const SpringNetwork& network);

/// Networks of more points than this take longer than seconds.
constexpr std::size_t kMaxForGlobalRigidity = 1000;

/// Returns whether the graph of the springs is generically globally rigid in space: the spring lengths
/// determine the positions of the points up to rigid motions and reflections, unless the points are in
/// special position. This holds if and only if the rank of a random equilibrium stress matrix of a random
/// placement is #points - 4 (Gortler, Healy, Thurston 2010, theorem 1.14 and section 5; graphs of at most 4
/// points: if all are joined). It is computed in a finite field, where ranks are exact: true is certain,
/// false is wrong with a probability of less than 1e-5. For up to kMaxForGlobalRigidity points. `goOn` is
/// called with the progress, 0 to 1; after it has returned false, the result is meaningless.
bool isGloballyRigid(const SpringNetwork& network, std::uint64_t seed = 1,
                     const std::function<bool(double)>& goOn = {});

/// Returns a seed that differs from `seed`: a network that was braced against the deformations of one seed
/// must not be measured with the same ones.
std::uint64_t measuringSeed(std::uint64_t seed);

/// Releases the network from `runs` seeded deformations of this kind, lightly damped, with the volume term of
/// a body with default settings, and counts the runs that return. Run i depends on (kind, seed, i) alone.
/// `progress` may be empty; when it returns false, the result covers the runs done so far. There are no runs
/// if their results would be meaningless, see canRelax(). The seed of the deformations is
/// measuringSeed(seed).
ReturnRate measureReturns(const SpringNetwork& network, Deformation kind, std::uint32_t runs,
                          std::uint64_t seed, const Progress& progress = {},
                          const ParallelFor& parallel = {});

/// Substeps of velocity Verlet. Dampers do not change them, see verlet_step.h.
struct TimeSteps {
  double critical =
      0.0;  ///< s: 2 / omega of the stiffest oscillation about the rest shape. Longer ones are unstable
  double safe = 0.0;  ///< s: from Gershgorin's bound of omega, which is valid at any deformation of the
                      ///< springs; the volume terms count as at rest
};

/// Returns the time steps of a body with the settings' masses, stiffness, scale and volume modulus; infinite
/// if nothing is stiff.
TimeSteps timeSteps(const SpringNetwork& network, const SoftBodySettings& settings);

/// Height, relative to that at rest, at which a body counts as standing.
constexpr double kStandingHeight = 0.9;

/// Returns the spring constant (N/m) with which a body keeps kStandingHeight of its height under its own
/// weight. The body is set down gently in its modelled orientation, tilted by half a degree, on a floor with
/// the friction of default settings, gravity along -y, and comes to rest. Its height then is compared to that
/// of a stiff body set down likewise, which may have toppled or rolled, and to the height of its rest shape
/// in its present orientation. So a body that sinks, topples because it is soft, or leans over does not
/// stand. If that happens before it has sunk so far, the result is the constant with which it still stands,
/// higher than kStandingHeight. The error is about 1 % where a body sinks gradually; where it falls over,
/// that depends on small causes, by some 10 %. Infinite for bodies that never stand, 0 without gravity or
/// springs, and for pieces that lie flat.
///
/// In units of the size L, the mean mass m of a point and the stiffness k, a body at rest depends only on the
/// load m g / (k L). The function raises the load slowly until the body has this height. It uses the settings
/// that define these units (total mass, scale, stiffness) and the volume modulus, whose ratio to the
/// stiffness is kept. Damping does not matter at rest. `gravity` is in m/s^2.
///
/// Pieces that no spring joins are tested one by one; the largest constant is returned. Returns nothing if
/// `progress` (may be empty) ends it early, or if some springs are so much stiffer than others, or the body
/// is so slow to come to rest, that this would need too many steps.
std::optional<double> standingStiffness(const SpringNetwork& network, const SoftBodySettings& settings,
                                        double gravity, const Progress& progress = {});

/// Counts the edges of a surface that pass through the inside of one of its triangles. If two triangles
/// cross, an edge of one of them does. Coincident or touching sheets, and edges that intersect edges, do not
/// count.
std::size_t countPiercingEdges(const std::vector<Eigen::Vector3d>& points,
                               const std::vector<Triangle>& triangles);

}  // namespace limber
