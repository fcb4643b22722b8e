// SPDX-License-Identifier: Zlib
// Declares the assembly of sparse symmetric matrices from blocks of 3 x 3.
#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>

#include <vector>

namespace limber {

using Triplets = std::vector<Eigen::Triplet<double>>;

/// Adds the block of points i and j: its lower half on the diagonal, all of it below, nothing above.
inline void addBlock(Triplets& triplets, Eigen::Index i, Eigen::Index j, const Eigen::Matrix3d& block) {
  for (Eigen::Index r = 0; r < 3; ++r)
    for (Eigen::Index c = 0; c < 3; ++c)
      if (3 * i + r >= 3 * j + c) triplets.emplace_back(3 * i + r, 3 * j + c, block(r, c));
}

/// Returns the lower triangle of the sum of the blocks, 3 `points` x 3 `points`.
inline Eigen::SparseMatrix<double> sumOf(const Triplets& triplets, Eigen::Index points) {
  Eigen::SparseMatrix<double> matrix(3 * points, 3 * points);
  matrix.setFromTriplets(triplets.begin(), triplets.end());
  return matrix;
}

/// Returns the product of a symmetric matrix, of which only the lower triangle is stored, with some columns.
inline Eigen::MatrixXd symmetricProduct(const Eigen::SparseMatrix<double>& lower,
                                        const Eigen::MatrixXd& columns) {
  return lower.selfadjointView<Eigen::Lower>() * columns;
}

}  // namespace limber
