// SPDX-License-Identifier: Zlib
#include "solver/linear_algebra.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>

#include <cmath>
#include <vector>

namespace limber {
namespace {

constexpr double kNothing = 1e-14;

using DenseSolver = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>;

/// x -> x - scale (normal . x) normal, of the last rows of x (A. Householder, 1958).
struct Reflection {
  Eigen::VectorXd normal;
  double scale;
};

/// Turns the column, from row `first` on, into the direction of that row's axis. Eigen's own takes five seconds
/// to compile, most of them for blocks of columns.
Reflection reflectionOntoAxis(const Eigen::Ref<const Eigen::VectorXd>& column, Eigen::Index first) {
  Reflection r{column.tail(column.size() - first), 0.0};
  r.normal[0] += std::copysign(r.normal.norm(), r.normal[0]);
  const double squared = r.normal.squaredNorm();
  if (squared > 0.0) r.scale = 2.0 / squared;
  return r;
}

void reflect(const Reflection& r, Eigen::Ref<Eigen::VectorXd> x) {
  auto rest = x.tail(r.normal.size());
  rest -= (r.scale * r.normal.dot(rest)) * r.normal;
}

}  // namespace

Eigen::MatrixXd product(const MatrixView& a, const MatrixView& b) { return a * b; }

Eigen::MatrixXd transposedProduct(const MatrixView& a, const MatrixView& b) { return a.transpose() * b; }

SymmetricParts symmetricParts(const Eigen::MatrixXd& matrix) {
  const DenseSolver solver(matrix);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

SymmetricParts3 symmetricParts3(const Eigen::Matrix3d& matrix) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(matrix);  // allocates nothing
  return {solver.eigenvalues(), solver.eigenvectors()};
}

Eigen::VectorXd symmetricValues(const Eigen::MatrixXd& matrix) {
  return DenseSolver(matrix, Eigen::EigenvaluesOnly).eigenvalues();
}

SymmetricParts tridiagonalParts(const Eigen::VectorXd& diagonal, const Eigen::VectorXd& coupling) {
  DenseSolver solver;
  solver.computeFromTridiagonal(diagonal, coupling);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

Eigen::Matrix3d pseudoInverse(const Eigen::Matrix3d& matrix) {
  const SymmetricParts3 parts = symmetricParts3(matrix);
  const double least = kNothing * parts.values.cwiseAbs().maxCoeff();
  Eigen::Matrix3d inverse = Eigen::Matrix3d::Zero();
  for (int k = 0; k < 3; ++k)
    if (std::abs(parts.values[k]) > least)
      inverse += parts.vectors.col(k) * parts.vectors.col(k).transpose() / parts.values[k];
  return inverse;
}

void solveSmall(const SmallMatrix& matrix, Eigen::Ref<Eigen::MatrixXd> columns) {
  const Eigen::LDLT<SmallMatrix> factors(matrix);
  SmallVector x;
  for (Eigen::Index j = 0; j < columns.cols(); ++j) {
    x = columns.col(j);
    factors.solveInPlace(x);
    columns.col(j) = x;
  }
}

LuFactor::LuFactor(const Eigen::MatrixXd& matrix)
    : factors_(std::make_unique<Eigen::PartialPivLU<Eigen::MatrixXd>>(matrix)) {}

LuFactor::~LuFactor() = default;

Eigen::MatrixXd LuFactor::solve(const Eigen::MatrixXd& right) const { return factors_->solve(right); }

Eigen::MatrixXd LuFactor::inverse() const {
  return solve(Eigen::MatrixXd::Identity(factors_->rows(), factors_->cols()));
}

Eigen::MatrixXd orthogonalColumns(const Eigen::MatrixXd& columns, Eigen::Index count) {
  Eigen::MatrixXd left = columns, result = Eigen::MatrixXd::Identity(columns.rows(), count);
  std::vector<Reflection> reflections;
  for (Eigen::Index k = 0; k < columns.cols(); ++k) {
    reflections.push_back(reflectionOntoAxis(left.col(k), k));
    for (Eigen::Index j = k + 1; j < left.cols(); ++j) reflect(reflections.back(), left.col(j));
  }
  for (auto r = reflections.rbegin(); r != reflections.rend(); ++r)
    for (Eigen::Index j = 0; j < count; ++j) reflect(*r, result.col(j));
  return result;
}

}  // namespace limber
