// SPDX-License-Identifier: Zlib
#include "solver/sparse_factor.h"

#include <Eigen/SparseCholesky>

namespace limber {

SparseFactor factorise(const Eigen::SparseMatrix<double>& matrix) {
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> cholesky(matrix);
  SparseFactor factor;
  factor.isComplete = cholesky.info() == Eigen::Success;
  factor.place = cholesky.permutationP().indices();
  if (factor.isComplete) {
    factor.lower = cholesky.matrixL().nestedExpression();
    factor.diagonal = cholesky.vectorD();
  } else {
    factor.lower.resize(matrix.rows(), matrix.cols());
    factor.diagonal.setZero(matrix.rows());
  }
  return factor;
}

Eigen::VectorXd solve(const SparseFactor& factor, const Eigen::VectorXd& b) {
  Eigen::VectorXd ordered(b.size()), x(b.size());
  for (Eigen::Index i = 0; i < b.size(); ++i) ordered[factor.place[i]] = b[i];
  solveOrdered(factor, ordered);
  for (Eigen::Index i = 0; i < b.size(); ++i) x[i] = ordered[factor.place[i]];
  return x;
}

Eigen::MatrixXd solve(const SparseFactor& factor, const Eigen::MatrixXd& b) {
  Eigen::MatrixXd x(b.rows(), b.cols());
  for (Eigen::Index j = 0; j < b.cols(); ++j) x.col(j) = solve(factor, Eigen::VectorXd(b.col(j)));
  return x;
}

}  // namespace limber
