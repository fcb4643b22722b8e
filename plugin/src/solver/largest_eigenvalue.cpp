// SPDX-License-Identifier: Zlib
#include "solver/largest_eigenvalue.h"

#include "core/random.h"
#include "solver/linear_algebra.h"

#include <algorithm>
#include <cmath>

namespace limber {
namespace {

constexpr Eigen::Index kMostSteps = 400;
constexpr Eigen::Index kStepsBetweenChecks = 8;

/// Below this part of the largest entry so far the space is used up: what remains is round-off.
constexpr double kUsedUp = 1e-14;

/// Entries beyond this have squares that are no numbers; files may have such.
constexpr double kHuge = 1e100;

double lengthOf(const Eigen::VectorXd& v) {
  const double norm = v.norm();
  return std::isfinite(norm) ? norm : v.stableNorm();
}

/// Of the tridiagonal matrix whose entries are `scale` at most.
struct Ritz {
  double largest, lastEntry;  ///< its largest eigenvalue, and the last entry of the vector that belongs to it
};

Ritz solve(const Eigen::VectorXd& diagonal, const Eigen::VectorXd& coupling, double scale) {
  const double unit = scale > kHuge ? scale : 1.0;
  const SymmetricParts parts = tridiagonalParts(diagonal / unit, coupling / unit);
  const Eigen::Index last = diagonal.size() - 1;
  return {parts.values[last] * unit, parts.vectors(last, last)};
}

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
    basis.col(k) = v / (k == 0 ? lengthOf(v) : coupling[k - 1]);
    v = multiply(basis.col(k));
    diagonal[k] = basis.col(k).dot(v);
    for (int pass = 0; pass < 2; ++pass)
      v -= basis.leftCols(k + 1) * (basis.leftCols(k + 1).transpose() * v).eval();
    coupling[k] = lengthOf(v);
    scale = std::max({scale, std::abs(diagonal[k]), coupling[k]});
    const bool usedUp = coupling[k] <= kUsedUp * scale;
    if (!usedUp && k + 1 < steps && (k + 1) % kStepsBetweenChecks != 0) continue;
    const Ritz ritz = solve(diagonal.head(k + 1), coupling.head(k), scale);
    largest = ritz.largest;
    const double residual = coupling[k] * std::abs(ritz.lastEntry);
    if (usedUp || residual <= tolerance * std::abs(largest)) break;
  }
  return largest;
}

}  // namespace limber
