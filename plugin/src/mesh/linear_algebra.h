// SPDX-License-Identifier: Zlib
#pragma once

// Small dense matrices, factors of sparse ones, and the largest eigenvalue of a linear operator.

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <Eigen/SparseCore>

#include <functional>
#include <vector>

namespace limber {

// Eigen's decompositions and large products, compiled once: each instantiation takes seconds to compile.

/// A matrix, or a block of one, without a copy.
using MatrixView = Eigen::Ref<const Eigen::MatrixXd>;

/// a b
Eigen::MatrixXd product(const MatrixView& a, const MatrixView& b);

/// a^T b
Eigen::MatrixXd transposedProduct(const MatrixView& a, const MatrixView& b);

// --- symmetric matrices, of which only the lower triangle is read ------------------------------------------

/// Eigenvalues in ascending order, and their unit eigenvectors as columns.
struct SymmetricParts {
  Eigen::VectorXd values;
  Eigen::MatrixXd vectors;
};
struct SymmetricParts3 {
  Eigen::Vector3d values;
  Eigen::Matrix3d vectors;
};

SymmetricParts symmetricParts(const Eigen::MatrixXd& matrix);
SymmetricParts3 symmetricParts3(const Eigen::Matrix3d& matrix);

/// Returns only the eigenvalues, in ascending order.
Eigen::VectorXd symmetricValues(const Eigen::MatrixXd& matrix);

/// Returns the matrix whose product with a vector b is the shortest x that minimises |matrix x - b|.
/// Eigenvalues below 1e-14 of the largest count as 0.
Eigen::Matrix3d pseudoInverse(const Eigen::Matrix3d& matrix);

/// Returns the matrix whose eigenvector of the largest eigenvalue is the quaternion (w, x, y, z) of the
/// rotation that brings points x nearest to points y, for the sum of all x y^T, both about their means (B.
/// Horn, Closed-form solution of absolute orientation using unit quaternions, 1987). That eigenvalue is the
/// sum of all y . (rotation x).
Eigen::MatrixXd quaternionMatrix(const Eigen::Matrix3d& sum);

/// Returns the rotation and translation that bring points (3 x #points, m) nearest to others: the sum of the
/// squared distances is least. If several rotations do, as for points on a line, returns the smallest one.
Eigen::Isometry3d rigidMotionBetween(const Eigen::Matrix3Xd& from, const Eigen::Matrix3Xd& to);

/// Matrices up to 10 x 10 and vectors up to 10 entries, without an allocation.
constexpr int kMaxSmall = 10;
using SmallMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxSmall, kMaxSmall>;
using SmallVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxSmall, 1>;

/// Solves a small symmetric system in place for each column of right sides.
void solveSmall(const SmallMatrix& matrix, Eigen::Ref<Eigen::MatrixXd> columns);

// --- any matrices ------------------------------------------------------------------------------------------

/// Returns the first `count` columns of an orthogonal matrix whose first columns span the same space as
/// `columns`, which is not wider than high.
Eigen::MatrixXd orthogonalColumns(const Eigen::MatrixXd& columns, Eigen::Index count);

// --- sparse matrices ---------------------------------------------------------------------------------------

/// Returns the place of each row in an order that keeps the factor of a symmetric matrix sparse (approximate
/// minimum degree: Amestoy, Davis, Duff 1996). Reads only the lower triangle, and no values.
Eigen::VectorXi sparseOrder(const Eigen::SparseMatrix<double>& matrix);

/// P A P^T = L D L^T of a symmetric matrix A, with a permutation P that keeps L sparse. There is no pivoting.
struct SparseFactor {
  Eigen::SparseMatrix<double> lower;  ///< L without its diagonal, which is 1
  Eigen::VectorXd diagonal;           ///< D
  Eigen::VectorXi place;              ///< the row of L for each row of A
  bool isComplete = false;            ///< false: a pivot was 0, and no solution is finite
};

/// Reads only the lower triangle of the matrix.
SparseFactor factorise(const Eigen::SparseMatrix<double>& matrix);

/// Returns A^-1 b, for one vector or for each column.
Eigen::VectorXd solve(const SparseFactor& factor, const Eigen::VectorXd& b);
Eigen::MatrixXd solve(const SparseFactor& factor, const Eigen::MatrixXd& b);

/// Solves  L D L^T x = b  in place for several vectors as columns. Rows are in the order of L.
template <class Rows>
void solveOrdered(const SparseFactor& factor, Rows&& x) {
  using Entry = Eigen::SparseMatrix<double>::InnerIterator;
  const Eigen::Index count = factor.lower.cols();
  for (Eigen::Index j = 0; j < count; ++j) {
    const auto solved = x.row(j).eval();
    for (Entry entry(factor.lower, j); entry; ++entry) x.row(entry.row()) -= entry.value() * solved;
  }
  for (Eigen::Index j = 0; j < count; ++j) x.row(j) /= factor.diagonal[j];
  for (Eigen::Index j = count; j-- > 0;) {
    auto sum = x.row(j).eval();
    for (Entry entry(factor.lower, j); entry; ++entry) sum -= entry.value() * x.row(entry.row());
    x.row(j) = sum;
  }
}

// Sparse symmetric matrices from blocks of 3 x 3:

using Triplets = std::vector<Eigen::Triplet<double>>;

/// Adds the block of points i and j: its lower half on the diagonal, all of it below, nothing above.
inline void addBlock(Triplets& triplets, Eigen::Index i, Eigen::Index j, const Eigen::Matrix3d& block) {
  for (Eigen::Index r = 0; r < 3; ++r)
    for (Eigen::Index c = 0; c < 3; ++c)
      if (3 * i + r >= 3 * j + c) triplets.emplace_back(3 * i + r, 3 * j + c, block(r, c));
}

/// Returns the lower triangle of the sum of the blocks, 3 `points` x 3 `points`.
inline Eigen::SparseMatrix<double> sumOf(const Triplets& triplets, Eigen::Index points) {
  Eigen::SparseMatrix<double> matrix(3 * points, 3 * points);
  matrix.setFromTriplets(triplets.begin(), triplets.end());
  return matrix;
}

/// Returns the product of a symmetric matrix, of which only the lower triangle is stored, with some columns.
inline Eigen::MatrixXd symmetricProduct(const Eigen::SparseMatrix<double>& lower,
                                        const Eigen::MatrixXd& columns) {
  return lower.selfadjointView<Eigen::Lower>() * columns;
}

// --- the largest eigenvalue --------------------------------------------------------------------------------

/// A symmetric matrix, given by its product with a vector.
using SymmetricOperator = std::function<Eigen::VectorXd(const Eigen::VectorXd&)>;

/// Returns the largest eigenvalue (algebraically) of a symmetric matrix of `size` rows, or 0 for no rows.
/// Uses Lanczos iteration with full orthogonalisation from a seeded start, to a residual of `tolerance` times
/// the eigenvalue; the eigenvalue's error is about the square of that (Parlett 1998, chapter 11).
double largestEigenvalue(const SymmetricOperator& multiply, Eigen::Index size, double tolerance = 1e-5);

}  // namespace limber
