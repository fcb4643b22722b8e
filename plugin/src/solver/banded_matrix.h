// SPDX-License-Identifier: Zlib
#pragma once

#include <Eigen/Core>

namespace limber {

/// A symmetric positive definite matrix with `width` diagonals below the main one: A(i, j) for
/// i - width <= j <= i. Column j of `band` holds A(j, j), A(j + 1, j), ... A(j + width, j).
struct BandedMatrix {
  Eigen::MatrixXd band;  ///< (width + 1) x size

  void resize(Eigen::Index size, Eigen::Index width) { band.resize(width + 1, size); }
  Eigen::Index size() const { return band.cols(); }
  Eigen::Index width() const { return band.rows() - 1; }
  double& at(Eigen::Index i, Eigen::Index j) { return band(i - j, j); }  ///< i >= j
};

/// Replaces A by the factors of A = L D L^T (D on the diagonal, L unit lower triangular below it), in about
/// size x width^2 operations (Golub, Van Loan 2013, section 4.3). A pivot that is not above 0, which rounding
/// can bring about, becomes 1.
void factorise(BandedMatrix& matrix);

/// Solves A x = b in place with the factors.
void solve(const BandedMatrix& factors, Eigen::Ref<Eigen::VectorXd> b);

}  // namespace limber
