// SPDX-License-Identifier: Zlib
#pragma once

#include <Eigen/SparseCore>

namespace limber {

/// P A P^T = L D L^T of a symmetric matrix A, with an order P that leaves few entries. There is no pivoting.
struct SparseFactor {
  Eigen::SparseMatrix<double> lower;  ///< L without its diagonal, which is 1
  Eigen::VectorXd diagonal;           ///< D
  Eigen::VectorXi place;              ///< which row of L belongs to a row of A
  bool isComplete = false;            ///< false: a pivot was 0, and no solution is finite
};

/// Only the lower triangle of the matrix is read.
SparseFactor factorise(const Eigen::SparseMatrix<double>& matrix);

/// A^-1 b, for one vector or for columns of them.
Eigen::VectorXd solve(const SparseFactor& factor, const Eigen::VectorXd& b);
Eigen::MatrixXd solve(const SparseFactor& factor, const Eigen::MatrixXd& b);

/// Solves  L D L^T x = b  in place, with several vectors side by side: rows are in the order of L.
template <class Rows>
void solveOrdered(const SparseFactor& factor, Rows&& x) {
  using Entry = Eigen::SparseMatrix<double>::InnerIterator;
  const Eigen::Index count = factor.lower.cols();
  for (Eigen::Index j = 0; j < count; ++j)
    for (Entry entry(factor.lower, j); entry; ++entry) x.row(entry.row()) -= entry.value() * x.row(j);
  for (Eigen::Index j = 0; j < count; ++j) x.row(j) /= factor.diagonal[j];
  for (Eigen::Index j = count; j-- > 0;)
    for (Entry entry(factor.lower, j); entry; ++entry) x.row(j) -= entry.value() * x.row(entry.row());
}

}  // namespace limber
