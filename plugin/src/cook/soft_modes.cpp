// SPDX-License-Identifier: Zlib
#include "cook/rigidity.h"
#include "cook/stiffness_matrix.h"
#include "core/random.h"
#include "solver/linear_algebra.h"

#include <algorithm>
#include <cmath>

namespace limber {
namespace {

/// Up to so many unknowns all modes are computed at once.
constexpr Eigen::Index kMostDenseModes = 450;

constexpr Eigen::Index kBlock = 8;  // vectors that the space grows by
constexpr int kMostBlocks = 400;    // by then something is wrong with the matrix
constexpr int kBlocksBetweenChecks = 3;
constexpr double kModeTolerance = 1e-5;  // of a residual, relative to the eigenvalue of the inverse
constexpr double kConfirmed = 1e-4;      // relative change of an eigenvalue that says that nothing was missed
constexpr double kDependent = 1e-13;     // norm of what is left of a unit vector: round-off
constexpr double kRelativeShift = 1e-9;  // of the largest eigenvalue, added so that there is an inverse

using Block = Eigen::Matrix<double, Eigen::Dynamic, kBlock>;
using RowBlock = Eigen::Matrix<double, Eigen::Dynamic, kBlock, Eigen::RowMajor>;

/// Each eigenvalue lies within the sum of a row's magnitudes (Gershgorin).
double largestRowSum(const SparseMatrix& matrix) {
  Eigen::VectorXd sums = Eigen::VectorXd::Zero(matrix.rows());
  for (Eigen::Index j = 0; j < matrix.outerSize(); ++j)
    for (SparseMatrix::InnerIterator entry(matrix, j); entry; ++entry)
      sums[entry.row()] += std::abs(entry.value());
  return sums.size() ? sums.maxCoeff() : 0.0;
}

/// The modes within the space of `shapes` U (orthonormal): with  (R U)^T R U = B S B^T  they are U B. The
/// round-off of S is that of the stiffest mode of the space, not of all.
Modes modesWithin(const SparseMatrix& rigidity, const Eigen::MatrixXd& shapes) {
  const Eigen::MatrixXd stretches = rigidity * shapes;
  const SymmetricParts ritz = symmetricParts(transposedProduct(stretches, stretches));
  return {ritz.values.cwiseMax(0.0), product(shapes, ritz.vectors)};
}

/// With rigid motions made the stiffest of all.
Eigen::MatrixXd denseModes(const SparseMatrix& stiffness, const Eigen::MatrixXd& rigid, Eigen::Index count) {
  Eigen::MatrixXd matrix = stiffness;
  matrix += (2.0 * largestRowSum(stiffness) + 1.0) * product(rigid, rigid.transpose());
  return symmetricParts(matrix).vectors.leftCols(count);
}

/// (K + s)^-1 for several vectors at a time.
class ShiftedInverse {
 public:
  ShiftedInverse(const SparseMatrix& stiffness, double shift) {
    SparseMatrix shifted = stiffness;
    for (Eigen::Index i = 0; i < shifted.rows(); ++i) shifted.coeffRef(i, i) += shift;
    factor_ = factorise(shifted);
  }

  Block operator*(const Block& b) const {
    RowBlock x(b.rows(), kBlock);
    for (Eigen::Index i = 0; i < b.rows(); ++i) x.row(factor_.place[i]) = b.row(i);
    solveOrdered(factor_, x);
    Block result(b.rows(), kBlock);
    for (Eigen::Index i = 0; i < b.rows(); ++i) result.row(i) = x.row(factor_.place[i]);
    return result;
  }

 private:
  SparseFactor factor_;
};

/// The space that block Lanczos with thick restarts (Wu, Simon 2000) spans with the inverse, whose largest
/// eigenvalues are the softest modes. All products are kept instead of the three-term recurrence: spaces are
/// small, and then no round-off can bring false copies of modes.
struct SoftSpace {
  const ShiftedInverse& inverse;
  const Eigen::MatrixXd& rigid;
  Eigen::MatrixXd basis{}, product{};  ///< orthonormal, and the inverse times it; `columns` of them
  Eigen::Index columns = 0;
  Eigen::VectorXd values{};   ///< of the inverse within the space, descending
  Eigen::MatrixXd vectors{};  ///< columns x columns, in terms of the basis
  Random random{1};
};

void project(const SoftSpace& space, Eigen::Ref<Eigen::MatrixXd> block) {
  const auto basis = space.basis.leftCols(space.columns);
  block -= product(space.rigid, transposedProduct(space.rigid, block));
  block -= product(basis, transposedProduct(basis, block));
}

void randomise(SoftSpace& space, Eigen::Ref<Eigen::MatrixXd> block) {
  for (Eigen::Index j = 0; j < block.cols(); ++j)
    for (Eigen::Index i = 0; i < block.rows(); ++i) block(i, j) = space.random.uniform() - 0.5;
  block.colwise().normalize();
}

/// Orthonormal and orthogonal to the space and to rigid motions; random where nothing is left. Twice, since
/// once leaves the round-off of what was taken away (Parlett 1998, section 6.9).
Block orthonormal(SoftSpace& space, Block block) {
  block.colwise().normalize();
  for (int pass = 0; pass < 2; ++pass) {
    project(space, block);
    for (Eigen::Index j = 0; j < kBlock; ++j) {
      auto v = block.col(j);
      const auto earlier = block.leftCols(j);
      v -= earlier * (earlier.transpose() * v).eval();
      if (!(v.norm() > kDependent)) {
        randomise(space, v);
        project(space, v);
        v -= earlier * (earlier.transpose() * v).eval();
      }
      v.normalize();
    }
  }
  return block;
}

/// Adds the block to the space and returns what the inverse leads to from it.
Block extend(SoftSpace& space, const Block& block) {
  Block answer = space.inverse * block;
  answer -= product(space.rigid, transposedProduct(space.rigid, answer));
  space.basis.middleCols(space.columns, kBlock) = block;
  space.product.middleCols(space.columns, kBlock) = answer;
  space.columns += kBlock;
  return orthonormal(space, answer);
}

void solveWithin(SoftSpace& space) {
  Eigen::MatrixXd small =
      transposedProduct(space.basis.leftCols(space.columns), space.product.leftCols(space.columns));
  small = (0.5 * (small + small.transpose())).eval();
  const SymmetricParts ritz = symmetricParts(small);
  space.values = ritz.values.reverse();
  space.vectors = ritz.vectors.rowwise().reverse();
}

bool isConverged(const SoftSpace& space, Eigen::Index count) {
  const Eigen::MatrixXd residuals =
      product(space.product.leftCols(space.columns), space.vectors.leftCols(count)) -
      product(space.basis.leftCols(space.columns), space.vectors.leftCols(count)) *
          space.values.head(count).asDiagonal();
  return (residuals.colwise().norm().transpose().array() <= kModeTolerance * space.values.head(count).array())
      .all();
}

/// Shrinks the space to its softest `count` modes.
void keep(SoftSpace& space, Eigen::Index count) {
  space.basis.leftCols(count) = product(space.basis.leftCols(space.columns), space.vectors.leftCols(count));
  space.product.leftCols(count) =
      product(space.product.leftCols(space.columns), space.vectors.leftCols(count));
  space.columns = count;
}

Block randomBlock(SoftSpace& space) {
  Block block(space.rigid.rows(), kBlock);
  randomise(space, block);
  return orthonormal(space, block);
}

/// Grows the space until it holds the `count` softest modes, or for kMostBlocks blocks.
///
/// Symmetric shapes have equal modes and tessellated boxes many mechanisms, of which a Krylov space holds no
/// more than a block: what was found counts when fresh random vectors change nothing.
void converge(SoftSpace& space, Eigen::Index count) {
  Eigen::VectorXd found = Eigen::VectorXd::Zero(count);
  Block next = randomBlock(space);
  for (int round = 1, sinceFresh = 1; round <= kMostBlocks; ++round, ++sinceFresh) {
    next = extend(space, next);
    const bool isFull = space.columns + kBlock > space.basis.cols();
    if (space.columns < count || (sinceFresh % kBlocksBetweenChecks != 0 && !isFull)) continue;
    solveWithin(space);
    if (isConverged(space, count)) {
      const Eigen::VectorXd values = space.values.head(count);
      if (((values - found).array().abs() <= kConfirmed * values.array()).all()) return;
      found = values;
      keep(space, count);
      next = randomBlock(space);
      sinceFresh = 0;
    } else if (isFull) {
      keep(space, count + 2 * kBlock);
    }
  }
  solveWithin(space);  // it has grown since it was solved last
}

Eigen::MatrixXd sparseModes(const SparseMatrix& stiffness, const Eigen::MatrixXd& rigid, Eigen::Index count) {
  const double stiffest = largestRowSum(stiffness);
  const ShiftedInverse inverse(stiffness, stiffest > 0.0 ? kRelativeShift * stiffest : 1.0);
  SoftSpace space{inverse, rigid};
  space.basis.resize(stiffness.rows(), 2 * count + 6 * kBlock);
  space.product.resize(stiffness.rows(), space.basis.cols());
  converge(space, count);
  return product(space.basis.leftCols(space.columns),
                 space.vectors.leftCols(std::min(count, space.columns)));
}

constexpr int kRoughPasses = 2;

/// Inverse iteration of a random space (subspace iteration).
Eigen::MatrixXd roughShapes(const SparseMatrix& stiffness, const Eigen::MatrixXd& rigid, Eigen::Index count) {
  const double stiffest = largestRowSum(stiffness);
  const ShiftedInverse inverse(stiffness, stiffest > 0.0 ? kRelativeShift * stiffest : 1.0);
  Random random(1);
  Eigen::MatrixXd shapes(stiffness.rows(), (count + kBlock - 1) / kBlock * kBlock);
  for (double& x : shapes.reshaped()) x = random.uniform() - 0.5;
  for (int pass = 0; pass < kRoughPasses; ++pass) {
    shapes -= product(rigid, transposedProduct(rigid, shapes));
    for (Eigen::Index j = 0; j < shapes.cols(); j += kBlock)
      shapes.middleCols(j, kBlock) = inverse * Block(shapes.middleCols(j, kBlock));
    shapes -= product(rigid, transposedProduct(rigid, shapes));
    shapes = orthogonalColumns(shapes, shapes.cols());
  }
  return shapes;
}

}  // namespace

Modes roughModes(const SpringNetwork& network, std::size_t count) {
  const SparseMatrix rigidity = rigidityMatrix(network), stiffness = stiffnessMatrix(rigidity);
  if (stiffness.rows() <= kMostDenseModes || 4 * count > static_cast<std::size_t>(stiffness.rows()))
    return softestModes(network, count);
  return modesWithin(
      rigidity, roughShapes(stiffness, rigidMotions(network.restPoints), static_cast<Eigen::Index>(count)));
}

Modes softestModes(const SpringNetwork& network, std::size_t count) {
  const SparseMatrix rigidity = rigidityMatrix(network), stiffness = stiffnessMatrix(rigidity);
  const Eigen::MatrixXd rigid = rigidMotions(network.restPoints);
  const Eigen::Index unknowns = stiffness.rows(), there = unknowns - rigid.cols();
  const auto wanted = static_cast<Eigen::Index>(std::min(count, static_cast<std::size_t>(there)));
  if (wanted == 0) return {Eigen::VectorXd(0), Eigen::MatrixXd(unknowns, 0)};
  const bool isDense = unknowns <= kMostDenseModes || 4 * wanted > unknowns;
  return modesWithin(rigidity,
                     isDense ? denseModes(stiffness, rigid, wanted) : sparseModes(stiffness, rigid, wanted));
}

}  // namespace limber
