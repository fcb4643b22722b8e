// SPDX-License-Identifier: Zlib
// Declares the pieces of a network that springs connect, their stiffness at rest and their softest modes.
#pragma once

#include <limber/spring_network.h>

#include <Eigen/Core>
#include <Eigen/SparseCore>

#include <cstddef>
#include <cstdint>
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

}  // namespace limber
