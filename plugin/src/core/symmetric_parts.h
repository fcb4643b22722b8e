// SPDX-License-Identifier: Zlib
#pragma once

#include <Eigen/Core>

namespace limber {

// Eigen's solvers for symmetric matrices, compiled once: each instance of them takes seconds.

/// Eigenvalues in ascending order, and unit eigenvectors in the columns that belong to them.
struct SymmetricParts {
  Eigen::VectorXd values;
  Eigen::MatrixXd vectors;
};
struct SymmetricParts3 {
  Eigen::Vector3d values;
  Eigen::Matrix3d vectors;
};

/// Only the lower triangle of the matrix is read.
SymmetricParts symmetricParts(const Eigen::MatrixXd& matrix);
SymmetricParts3 symmetricParts3(const Eigen::Matrix3d& matrix);

/// The eigenvalues alone, in ascending order.
Eigen::VectorXd symmetricValues(const Eigen::MatrixXd& matrix);

/// Of the tridiagonal matrix with `diagonal` (n) and `coupling` (n - 1) beside it.
SymmetricParts tridiagonalParts(const Eigen::VectorXd& diagonal, const Eigen::VectorXd& coupling);

/// The x of least length that minimises |matrix x - right|: parts below 1e-14 of the largest are left out.
Eigen::Vector3d leastSolution(const Eigen::Matrix3d& matrix, const Eigen::Vector3d& right);

}  // namespace limber
