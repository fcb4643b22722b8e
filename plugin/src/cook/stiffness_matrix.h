// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/spring_network.h>

#include <Eigen/SparseCore>

namespace limber {

using SparseMatrix = Eigen::SparseMatrix<double>;

/// #springs x 3 #points: row s holds  sqrt(k) n  at the end b of spring s and  -sqrt(k) n  at a, n the unit
/// vector from a to b, k the spring's stiffnessScale. A motion u of the points stretches spring s by
/// (R u)_s / sqrt(k); springs without length or stiffness have empty rows.
SparseMatrix rigidityMatrix(const SpringNetwork& network);

/// 3 #points x 3 #points, N/m: the Hessian  R^T R  of the springs' energy at rest.
SparseMatrix stiffnessMatrix(const SparseMatrix& rigidity);

/// Orthonormal basis of the rigid motions of these points, 3 #points x 6; 5 columns for points on a line, 3
/// for a single one.
Eigen::MatrixXd rigidMotions(const std::vector<Eigen::Vector3d>& points);

}  // namespace limber
