// SPDX-License-Identifier: Zlib
#include "core/symmetric_parts.h"

#include <Eigen/Eigenvalues>

#include <cmath>

namespace limber {
namespace {

constexpr double kNothing = 1e-14;

using DenseSolver = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>;

}  // namespace

SymmetricParts symmetricParts(const Eigen::MatrixXd& matrix) {
  const DenseSolver solver(matrix);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

SymmetricParts3 symmetricParts3(const Eigen::Matrix3d& matrix) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(matrix);
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

Eigen::Vector3d leastSolution(const Eigen::Matrix3d& matrix, const Eigen::Vector3d& right) {
  const SymmetricParts3 parts = symmetricParts3(matrix);
  const double least = kNothing * parts.values.cwiseAbs().maxCoeff();
  Eigen::Vector3d x = Eigen::Vector3d::Zero();
  for (int k = 0; k < 3; ++k)
    if (std::abs(parts.values[k]) > least)
      x += parts.vectors.col(k).dot(right) / parts.values[k] * parts.vectors.col(k);
  return x;
}

}  // namespace limber
