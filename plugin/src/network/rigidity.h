// SPDX-License-Identifier: Zlib
// Declares the pieces of a network that springs connect, and the properties of their small deformations:
// stiffness, mechanisms, soft modes and global rigidity.
#pragma once

#include <limber/spring_network.h>

#include <Eigen/Core>
#include <Eigen/SparseCore>

#include <cstdint>
#include <functional>
#include <vector>

namespace limber {

/// Returns the points of each piece that springs connect, ascending; the pieces are in the order of their
/// first points.
std::vector<std::vector<Eigen::Index>> findPieces(const SpringNetwork& network);

/// Returns a network of these points and the springs, triangles and tetrahedra that join no others. Its mass
/// fractions sum to 1. Its report describes the edge defects of its part of the surface. It has no render
/// surface.
SpringNetwork pieceOf(const SpringNetwork& network, const std::vector<Eigen::Index>& points);

using SparseMatrix = Eigen::SparseMatrix<double>;

/// Returns the rigidity matrix R, #springs x 3 #points: row s holds  sqrt(k) n  at the end b of spring s and
/// -sqrt(k) n  at a. n is the unit vector from a to b, k the spring's stiffnessScale. A motion u of the
/// points stretches spring s by  (R u)_s / sqrt(k).  Springs without length or stiffness have empty rows.
SparseMatrix rigidityMatrix(const SpringNetwork& network);

/// Returns the Hessian  R^T R  of the springs' energy at rest, 3 #points x 3 #points, N/m.
SparseMatrix stiffnessMatrix(const SparseMatrix& rigidity);

/// Returns an orthonormal basis of the rigid motions of these points, 3 #points x 6; 5 columns for points on
/// a line, 3 for a single point.
Eigen::MatrixXd rigidMotions(const std::vector<Eigen::Vector3d>& points);

/// Small deformations of a network about its rest shape, with unit masses and without the volume term. The
/// constant of each spring is its stiffnessScale.
struct SmallDeformations {
  std::size_t rank = 0, mechanisms = 0, selfStresses = 0;
  double softest = 0.0,
         stiffest = 0.0;  ///< eigenvalues of the stiffness matrix, without mechanisms and rigid motions
};

SmallDeformations smallDeformations(const SpringNetwork& network);

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

}  // namespace limber
