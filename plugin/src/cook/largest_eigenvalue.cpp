// SPDX-License-Identifier: Zlib
#include "cook/largest_eigenvalue.h"

#include "cook/random.h"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>

namespace limber {
namespace {

constexpr Eigen::Index kMostSteps = 400;
constexpr Eigen::Index kStepsBetweenChecks = 8;

/// Below this part of the largest entry so far the space is used up: what remains is round-off.
constexpr double kUsedUp = 1e-14;

}  // namespace

double largestEigenvalue(const SymmetricOperator& multiply, Eigen::Index size, double tolerance) {
  const Eigen::Index steps = std::min(size, kMostSteps);
  Eigen::MatrixXd basis(size, steps);
  Eigen::VectorXd diagonal(steps), coupling(steps);
  Random random(1);
  Eigen::VectorXd v(size);
  for (double& x : v) x = random.uniform() - 0.5;
  double scale = 0.0, largest = 0.0;
  for (Eigen::Index k = 0; k < steps; ++k) {
    basis.col(k) = v.normalized();
    v = multiply(basis.col(k));
    diagonal[k] = basis.col(k).dot(v);
    for (int pass = 0; pass < 2; ++pass)
      v -= basis.leftCols(k + 1) * (basis.leftCols(k + 1).transpose() * v).eval();
    coupling[k] = v.norm();
    scale = std::max({scale, std::abs(diagonal[k]), coupling[k]});
    const bool usedUp = coupling[k] <= kUsedUp * scale;
    if (!usedUp && k + 1 < steps && (k + 1) % kStepsBetweenChecks != 0) continue;
    Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> ritz;
    ritz.computeFromTridiagonal(diagonal.head(k + 1), coupling.head(k));
    largest = ritz.eigenvalues()[k];
    const double residual = coupling[k] * std::abs(ritz.eigenvectors()(k, k));
    if (usedUp || residual <= tolerance * std::abs(largest)) break;
  }
  return largest;
}

}  // namespace limber
