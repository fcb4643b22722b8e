// SPDX-License-Identifier: Zlib
#include "solver/banded_matrix.h"

#include <algorithm>

namespace limber {

void factorise(BandedMatrix& matrix) {
  Eigen::MatrixXd& a = matrix.band;
  const Eigen::Index size = matrix.size(), width = matrix.width();
  for (Eigen::Index j = 0; j < size; ++j) {
    const Eigen::Index below = std::min(width, size - 1 - j);
    if (!(a(0, j) > 0.0)) a(0, j) = 1.0;
    // columns j + k lose l_k d l^T; l is column j divided by its pivot d
    for (Eigen::Index k = 1; k <= below; ++k) {
      const double factor = a(k, j) / a(0, j);
      if (factor != 0.0) a.col(j + k).head(below - k + 1) -= factor * a.col(j).segment(k, below - k + 1);
    }
    a.col(j).segment(1, below) /= a(0, j);
  }
}

void solve(const BandedMatrix& factors, Eigen::Ref<Eigen::VectorXd> b) {
  const Eigen::MatrixXd& a = factors.band;
  const Eigen::Index size = factors.size(), width = factors.width();
  for (Eigen::Index j = 0; j < size; ++j) {
    const Eigen::Index below = std::min(width, size - 1 - j);
    b.segment(j + 1, below) -= b[j] * a.col(j).segment(1, below);
  }
  for (Eigen::Index j = size; j-- > 0;) {
    const Eigen::Index below = std::min(width, size - 1 - j);
    b[j] = b[j] / a(0, j) - a.col(j).segment(1, below).dot(b.segment(j + 1, below));
  }
}

}  // namespace limber
