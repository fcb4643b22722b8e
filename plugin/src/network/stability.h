// SPDX-License-Identifier: Zlib

// Declares how a network keeps its shape: the pieces that springs connect, their stiffness at rest and their
// softest modes; bodies that move outside a world, their large deformations and their relaxation.

#pragma once

#include "solver/verlet_step.h"

#include <limber/network_builder.h>

#include <Eigen/Core>
#include <Eigen/SparseCore>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <vector>

namespace limber {

/// Returns the points of each piece that springs connect, ascending; the pieces are in the order of their
/// first points.
std::vector<std::vector<std::uint32_t>> findPieces(const SpringNetwork& network);

using SparseMatrix = Eigen::SparseMatrix<double>;

/// Returns the rigidity matrix R, #springs x 3 #points: row s holds  sqrt(k) n  at the end b of spring s and
/// -sqrt(k) n  at a. n is the unit vector from a to b, k the spring's stiffnessScale. A motion u of the
/// points stretches spring s by  (R u)_s / sqrt(k).  Springs without length or stiffness have empty rows.
SparseMatrix rigidityMatrix(const SpringNetwork& network);

/// Returns the Hessian  R^T R  of the springs' energy at rest, 3 #points x 3 #points, N/m.
SparseMatrix stiffnessMatrix(const SparseMatrix& rigidity);

/// Points about their centre. The axes are the principal ones, the thinnest first.
struct Spread {
  Eigen::Matrix3Xd offsets;  ///< from the centre, over `size`
  double size = 0.0;         ///< m, the largest coordinate of an offset
  Eigen::Vector3d scatter;   ///< eigenvalues of the sum of the squared offsets
  Eigen::Matrix3d axes;      ///< columns
};
Spread principalSpread(const std::vector<Eigen::Vector3d>& points);

/// Returns an orthonormal basis of the rigid motions of these points, 3 #points x 6; 5 columns for points on
/// a line, 3 for a single point.
Eigen::MatrixXd rigidMotions(const std::vector<Eigen::Vector3d>& points);

/// Returns the largest eigenvalue of a stiffness matrix.
double stiffestEigenvalue(const SparseMatrix& stiffness);

/// The softest oscillations, mechanisms first, without rigid motions.
struct Modes {
  Eigen::VectorXd eigenvalues;  ///< #modes, ascending
  Eigen::MatrixXd shapes;       ///< 3 #points x #modes, orthonormal
};

/// Returns the `count` softest modes, or all if there are fewer. Uses sparse matrices: takes seconds for 5
/// 000 points.
Modes softestModes(const SpringNetwork& network, std::size_t count);

/// Returns soft shapes that are not exact modes: the softest are close to modes, the last are rough. Each
/// eigenvalue is the Rayleigh quotient of its shape, so it is never too small. Takes a fraction of the time
/// of softestModes().
Modes roughModes(const SpringNetwork& network, std::size_t count);

// --- large deformations ------------------------------------------------------------------------------------

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
