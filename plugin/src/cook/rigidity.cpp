// SPDX-License-Identifier: Zlib
#include "cook/rigidity.h"

#include "cook/stiffness_matrix.h"
#include "core/random.h"
#include "solver/linear_algebra.h"

#include <algorithm>
#include <cmath>

namespace limber {
namespace {

/// A mode whose eigenvalue is below this part of the stiffest one's is a mechanism. The points of a mesh come
/// in single precision, which turns its springs by about 1e-6 and so moves the singular values of the
/// rigidity matrix by 1e-6 of the largest (Weyl) and eigenvalues, their squares, by 1e-12. The round-off of
/// double lies four powers of ten below.
constexpr double kMechanism = 1e-12;

/// Up to so many unknowns all eigenvalues are computed at once.
constexpr Eigen::Index kMostDense = 450;

/// Eigenvalues of the stiffness matrix on the mechanism's side of the bound, and the smallest on the other.
struct SoftEnd {
  Eigen::Index below = 0;
  double softest = 0.0;
};

SoftEnd denseSoftEnd(const SparseMatrix& stiffness, double bound) {
  const Eigen::VectorXd values = symmetricValues(stiffness);
  const Eigen::Index below = std::lower_bound(values.begin(), values.end(), bound) - values.begin();
  return {below, below < values.size() ? values[below] : 0.0};
}

/// Largest residual of solving with a factor, relative to the matrix, that speaks for its inertia.
constexpr double kSoundFactor = 1e-10;

bool isSound(const SparseFactor& factor, const SparseMatrix& matrix, double size) {
  if (!factor.isComplete) return false;
  Random random(1);
  Eigen::VectorXd b(matrix.rows());
  for (double& x : b) x = random.uniform() - 0.5;
  const Eigen::VectorXd x = solve(factor, b);
  return (matrix * x - b).norm() <= kSoundFactor * (size * x.norm() + b.norm());
}

/// Of  K - s  as many pivots are negative as K has eigenvalues below s (Sylvester), and the largest
/// eigenvalue of its inverse belongs to the first one above. Without pivoting a factor can be unsound where s
/// meets an eigenvalue of a leading block; then a somewhat larger s is taken.
SoftEnd sparseSoftEnd(const SparseMatrix& stiffness, double bound, double stiffest) {
  SparseFactor factor;
  double shift = 0.0;
  for (int attempt = 0; attempt < 6; ++attempt) {
    shift = bound * std::pow(1.7, attempt);
    SparseMatrix shifted = stiffness;
    for (Eigen::Index i = 0; i < shifted.rows(); ++i) shifted.coeffRef(i, i) -= shift;
    factor = factorise(shifted);
    if (isSound(factor, shifted, stiffest)) break;
  }
  if (!factor.isComplete) return denseSoftEnd(stiffness, bound);
  const Eigen::Index below = (factor.diagonal.array() < 0.0).count();
  if (below == stiffness.rows()) return {below, 0.0};
  const double inverse = largestEigenvalue(
      [&](const Eigen::VectorXd& v) -> Eigen::VectorXd { return solve(factor, v); }, stiffness.rows());
  return {below, inverse > 0.0 ? shift + 1.0 / inverse : 0.0};
}

}  // namespace

SmallDeformations smallDeformations(const SpringNetwork& network) {
  const SparseMatrix stiffness = stiffnessMatrix(rigidityMatrix(network));
  const Eigen::Index unknowns = stiffness.rows(), rigid = rigidMotions(network.restPoints).cols();
  SmallDeformations result;
  result.stiffest =
      largestEigenvalue([&](const Eigen::VectorXd& v) -> Eigen::VectorXd { return stiffness * v; }, unknowns);
  SoftEnd end{unknowns, 0.0};
  if (result.stiffest > 0.0) {
    const double bound = kMechanism * result.stiffest;
    end = unknowns <= kMostDense ? denseSoftEnd(stiffness, bound)
                                 : sparseSoftEnd(stiffness, bound, result.stiffest);
  }
  result.softest = end.softest;
  result.rank = static_cast<std::size_t>(unknowns - end.below);
  result.mechanisms = static_cast<std::size_t>(std::max<Eigen::Index>(end.below - rigid, 0));
  result.selfStresses = network.springs.size() - result.rank;
  return result;
}

}  // namespace limber
