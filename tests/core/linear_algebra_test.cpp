// SPDX-License-Identifier: Zlib
// Factors of sparse matrices, against dense algebra.

#include "mesh/linear_algebra.h"
#include "mesh/random.h"

#include <gtest/gtest.h>

#include <cstddef>

namespace limber {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

/// Returns the lower triangle of the matrix of a grid of `side`^3 points that are joined to all of their
/// neighbours, less `shift`: indefinite for a large one. It is dense enough for wide fronts.
Eigen::SparseMatrix<double> gridMatrix(Index side, double shift) {
  Random random(3);
  const Index points = side * side * side;
  using Place = Eigen::Array<Index, 3, 1>;
  const auto at = [&](Index p) { return Place(p % side, p / side % side, p / side / side); };
  std::vector<Eigen::Triplet<double>> entries;
  for (Index i = 0; i < points; ++i)
    for (Index j = 0; j <= i; ++j)
      if (i == j)
        entries.emplace_back(i, i, 26.0 - shift);
      else if ((at(i) - at(j)).abs().maxCoeff() == 1)
        entries.emplace_back(i, j, -random.uniform());
  Eigen::SparseMatrix<double> matrix(points, points);
  matrix.setFromTriplets(entries.begin(), entries.end());
  return matrix;
}

MatrixXd denseOf(const Eigen::SparseMatrix<double>& lower) {
  return MatrixXd(Eigen::SparseMatrix<double>(lower.selfadjointView<Eigen::Lower>()));
}

/// P A P^T = L D L^T, which is also what counts eigenvalues by the signs of D (Sylvester).
TEST(SparseFactor, multipliesToTheMatrix) {
  for (const Index side : {1, 2, 3, 7})
    for (const double shift : {0.0, 20.0, 30.0}) {
      const Eigen::SparseMatrix<double> matrix = gridMatrix(side, shift);
      const SparseFactor factor = factorise(matrix);
      ASSERT_TRUE(factor.isComplete);
      const MatrixXd unit = MatrixXd::Identity(matrix.rows(), matrix.rows());
      const MatrixXd lower = MatrixXd(factor.lower) + unit, dense = denseOf(matrix);
      MatrixXd placed(matrix.rows(), matrix.rows());
      for (Index i = 0; i < matrix.rows(); ++i)
        for (Index j = 0; j < matrix.rows(); ++j) placed(factor.place[i], factor.place[j]) = dense(i, j);
      const MatrixXd multiplied = product(lower * factor.diagonal.asDiagonal(), lower.transpose());
      // rounding, times the growth of entries without pivoting
      EXPECT_LT((multiplied - placed).norm(), 1e-11 * placed.norm()) << side << " shift " << shift;
      EXPECT_LT((product(dense, solve(factor, unit)) - unit).norm(), 1e-8 * double(matrix.rows()));
      const Eigen::Index negative = (symmetricValues(dense).array() < 0.0).count();
      EXPECT_EQ((factor.diagonal.array() < 0.0).count(), negative) << side << " shift " << shift;
    }
}

TEST(SparseFactor, readsOnlyTheLowerTriangle) {
  const Eigen::SparseMatrix<double> lower = gridMatrix(4, 0.0);
  Eigen::SparseMatrix<double> both = lower.selfadjointView<Eigen::Lower>();
  const Eigen::VectorXd x = Eigen::VectorXd::LinSpaced(64, -1.0, 1.0), expected = solve(factorise(lower), x);
  for (Index j = 0; j < both.cols(); ++j)
    for (Eigen::SparseMatrix<double>::InnerIterator entry(both, j); entry; ++entry)
      if (entry.row() < j) entry.valueRef() = 1e3;
  EXPECT_EQ(solve(factorise(both), x), expected);
}

/// Points that nothing joins, and none at all.
TEST(SparseFactor, isMadeOfPieces) {
  Eigen::SparseMatrix<double> matrix(5, 5);
  matrix.insert(0, 0) = 2.0;
  matrix.insert(2, 2) = 4.0;
  matrix.insert(4, 2) = 1.0;
  matrix.insert(4, 4) = -3.0;
  EXPECT_FALSE(factorise(matrix).isComplete) << "two rows are empty";
  matrix.insert(1, 1) = 1.0;
  matrix.insert(3, 3) = -1.0;
  const SparseFactor factor = factorise(matrix);
  ASSERT_TRUE(factor.isComplete);
  const Eigen::VectorXd b = Eigen::VectorXd::LinSpaced(5, 1.0, 5.0);
  EXPECT_LT((denseOf(matrix) * solve(factor, b) - b).norm(), 1e-14 * b.norm());
  EXPECT_TRUE(factorise(Eigen::SparseMatrix<double>(0, 0)).isComplete);
}

TEST(RigidMotion, isFoundOfAnyPointsAndIsNoReflection) {
  Random random(5);
  Eigen::Matrix3Xd from(3, 20), to(3, 20);
  const auto randomVector = [&] {
    return Eigen::Vector3d(random.uniform() - 0.5, random.uniform() - 0.5, random.uniform() - 0.5);
  };
  for (const bool flat : {false, true}) {
    for (Index i = 0; i < from.cols(); ++i) from.col(i) = randomVector();
    if (flat) from.row(2).setConstant(0.3);
    for (const double angle : {0.0, 1e-3, 2.0, 3.14159}) {
      const Eigen::Isometry3d motion =
          Eigen::Translation3d(randomVector()) * Eigen::AngleAxisd(angle, randomVector().normalized());
      to = motion * from;
      EXPECT_LT((rigidMotionBetween(from, to).matrix() - motion.matrix()).norm(), 1e-12) << flat << angle;
    }
  }
  for (Index i = 0; i < from.cols(); ++i) from.col(i) = randomVector();
  to = from;
  to.row(0) *= -1.0;
  EXPECT_NEAR(rigidMotionBetween(from, to).linear().determinant(), 1.0, 1e-12) << "mirrored";
}

}  // namespace
}  // namespace limber
