// SPDX-License-Identifier: Zlib
#include "cook/rigidity.h"
#include "cook/stiffness_matrix.h"
#include "core/random.h"
#include "core/symmetric_parts.h"

#include <Eigen/QR>
#include <Eigen/SparseCholesky>

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
  const SymmetricParts ritz = symmetricParts(stretches.transpose() * stretches);
  return {ritz.values.cwiseMax(0.0), shapes * ritz.vectors};
}

/// With rigid motions made the stiffest of all.
Eigen::MatrixXd denseModes(const SparseMatrix& stiffness, const Eigen::MatrixXd& rigid, Eigen::Index count) {
  Eigen::MatrixXd matrix = stiffness;
  matrix += (2.0 * largestRowSum(stiffness) + 1.0) * rigid * rigid.transpose();
  return symmetricParts(matrix).vectors.leftCols(count);
}

/// (K + s)^-1 for several vectors at a time.
class ShiftedInverse {
 public:
  ShiftedInverse(const SparseMatrix& stiffness, double shift) {
    SparseMatrix shifted = stiffness;
    for (Eigen::Index i = 0; i < shifted.rows(); ++i) shifted.coeffRef(i, i) += shift;
    factors_.compute(shifted);
    lower_ = factors_.matrixL();
    diagonal_ = factors_.vectorD();
  }

  Block operator*(const Block& b) const {
    RowBlock x = factors_.permutationP() * b;
    for (Eigen::Index j = 0; j < lower_.cols(); ++j)
      for (SparseMatrix::InnerIterator entry(lower_, j); entry; ++entry)
        if (entry.row() > j) x.row(entry.row()) -= entry.value() * x.row(j);
    x = diagonal_.cwiseInverse().asDiagonal() * x;
    for (Eigen::Index j = lower_.cols(); j-- > 0;)
      for (SparseMatrix::InnerIterator entry(lower_, j); entry; ++entry)
        if (entry.row() > j) x.row(j) -= entry.value() * x.row(entry.row());
    return factors_.permutationPinv() * x;
  }

 private:
  Eigen::SimplicialLDLT<SparseMatrix> factors_;
  SparseMatrix lower_;
  Eigen::VectorXd diagonal_;
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
  block -= space.rigid * (space.rigid.transpose() * block).eval();
  block -= basis * (basis.transpose() * block).eval();
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
  Block product = space.inverse * block;
  product -= space.rigid * (space.rigid.transpose() * product).eval();
  space.basis.middleCols(space.columns, kBlock) = block;
  space.product.middleCols(space.columns, kBlock) = product;
  space.columns += kBlock;
  return orthonormal(space, product);
}

void solveWithin(SoftSpace& space) {
  Eigen::MatrixXd small =
      space.basis.leftCols(space.columns).transpose() * space.product.leftCols(space.columns);
  small = (0.5 * (small + small.transpose())).eval();
  const SymmetricParts ritz = symmetricParts(small);
  space.values = ritz.values.reverse();
  space.vectors = ritz.vectors.rowwise().reverse();
}

bool isConverged(const SoftSpace& space, Eigen::Index count) {
  const Eigen::MatrixXd residuals = space.product.leftCols(space.columns) * space.vectors.leftCols(count) -
                                    space.basis.leftCols(space.columns) * space.vectors.leftCols(count) *
                                        space.values.head(count).asDiagonal();
  return (residuals.colwise().norm().transpose().array() <= kModeTolerance * space.values.head(count).array())
      .all();
}

/// Shrinks the space to its softest `count` modes.
void keep(SoftSpace& space, Eigen::Index count) {
  space.basis.leftCols(count) = (space.basis.leftCols(space.columns) * space.vectors.leftCols(count)).eval();
  space.product.leftCols(count) =
      (space.product.leftCols(space.columns) * space.vectors.leftCols(count)).eval();
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
  return space.basis.leftCols(space.columns) * space.vectors.leftCols(std::min(count, space.columns));
}

constexpr int kRoughPasses = 2;

Eigen::MatrixXd orthonormal(const Eigen::MatrixXd& columns) {
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr(columns);
  return qr.householderQ() * Eigen::MatrixXd::Identity(columns.rows(), columns.cols());
}

/// Inverse iteration of a random space (subspace iteration).
Eigen::MatrixXd roughShapes(const SparseMatrix& stiffness, const Eigen::MatrixXd& rigid, Eigen::Index count) {
  const double stiffest = largestRowSum(stiffness);
  const ShiftedInverse inverse(stiffness, stiffest > 0.0 ? kRelativeShift * stiffest : 1.0);
  Random random(1);
  Eigen::MatrixXd shapes(stiffness.rows(), (count + kBlock - 1) / kBlock * kBlock);
  for (double& x : shapes.reshaped()) x = random.uniform() - 0.5;
  for (int pass = 0; pass < kRoughPasses; ++pass) {
    shapes -= rigid * (rigid.transpose() * shapes).eval();
    for (Eigen::Index j = 0; j < shapes.cols(); j += kBlock)
      shapes.middleCols(j, kBlock) = inverse * Block(shapes.middleCols(j, kBlock));
    shapes -= rigid * (rigid.transpose() * shapes).eval();
    shapes = orthonormal(shapes);
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
