// SPDX-License-Identifier: Zlib
// Compiles the decompositions of Eigen that are used; computes the largest eigenvalue by Lanczos iteration.
#include "mesh/linear_algebra.h"

#include "mesh/random.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/SparseCholesky>

#include <algorithm>
#include <cmath>
#include <vector>

namespace limber {
namespace {

constexpr double kNegligibleEigenvalue = 1e-14;

using DenseSolver = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>;

/// x -> x - scale (normal . x) normal, for the last rows of x (A. Householder, 1958).
struct Reflection {
  Eigen::VectorXd normal;
  double scale;
};

/// Returns the reflection that maps the column, from row `first` on, to the direction of that row's axis.
/// Eigen's own version takes five seconds to compile, most of them for blocks of columns.
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
  const double limit = kNegligibleEigenvalue * parts.values.cwiseAbs().maxCoeff();
  Eigen::Matrix3d inverse = Eigen::Matrix3d::Zero();
  for (int k = 0; k < 3; ++k)
    if (std::abs(parts.values[k]) > limit)
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

/// Columns that stay in the caches while all reflections pass over them.
constexpr Eigen::Index kColumnsAtOnce = 8;

Eigen::MatrixXd orthogonalColumns(const Eigen::MatrixXd& columns, Eigen::Index count) {
  Eigen::MatrixXd reduced = columns, result = Eigen::MatrixXd::Identity(columns.rows(), count);
  std::vector<Reflection> reflections;
  for (Eigen::Index first = 0; first < columns.cols(); first += kColumnsAtOnce) {
    const Eigen::Index end = std::min(first + kColumnsAtOnce, columns.cols());
    for (const Reflection& r : reflections)
      for (Eigen::Index j = first; j < end; ++j) reflect(r, reduced.col(j));
    for (Eigen::Index k = first; k < end; ++k) {
      reflections.push_back(reflectionOntoAxis(reduced.col(k), k));
      for (Eigen::Index j = k + 1; j < end; ++j) reflect(reflections.back(), reduced.col(j));
    }
  }
  for (Eigen::Index first = 0; first < count; first += kColumnsAtOnce)
    for (auto r = reflections.rbegin(); r != reflections.rend(); ++r)
      for (Eigen::Index j = first; j < std::min(first + kColumnsAtOnce, count); ++j)
        reflect(*r, result.col(j));
  return result;
}

// --- sparse matrices ---------------------------------------------------------------------------------------

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

/// Columns that are solved together: each pass over L serves all of them.
constexpr Eigen::Index kTogether = 8;

Eigen::MatrixXd solve(const SparseFactor& factor, const Eigen::MatrixXd& b) {
  using Rows = Eigen::Matrix<double, Eigen::Dynamic, kTogether, Eigen::RowMajor>;
  Rows ordered = Rows::Zero(b.rows(), kTogether);
  Eigen::MatrixXd x(b.rows(), b.cols());
  for (Eigen::Index first = 0; first < b.cols(); first += kTogether) {
    const Eigen::Index count = std::min(kTogether, b.cols() - first);
    for (Eigen::Index i = 0; i < b.rows(); ++i)
      ordered.row(factor.place[i]).head(count) = b.row(i).segment(first, count);
    solveOrdered(factor, ordered);
    for (Eigen::Index i = 0; i < b.rows(); ++i)
      x.row(i).segment(first, count) = ordered.row(factor.place[i]).head(count);
  }
  return x;
}

// --- the largest eigenvalue --------------------------------------------------------------------------------

namespace {

constexpr Eigen::Index kMaxSteps = 400;
constexpr Eigen::Index kStepsBetweenChecks = 8;

/// If an entry is below this share of the largest one so far, the space is exhausted: the rest is round-off.
constexpr double kExhausted = 1e-14;

/// Larger entries are scaled, since their squares may overflow; files may contain such numbers.
constexpr double kHuge = 1e100;

double lengthOf(const Eigen::VectorXd& v) {
  const double norm = v.norm();
  return std::isfinite(norm) ? norm : v.stableNorm();
}

/// The result for the tridiagonal matrix whose entries are `scale` at most.
struct Ritz {
  double largest, lastEntry;  ///< its largest eigenvalue, and the last entry of the eigenvector
};

Ritz solve(const Eigen::VectorXd& diagonal, const Eigen::VectorXd& coupling, double scale) {
  const double unit = scale > kHuge ? scale : 1.0;
  const SymmetricParts parts = tridiagonalParts(diagonal / unit, coupling / unit);
  const Eigen::Index last = diagonal.size() - 1;
  return {parts.values[last] * unit, parts.vectors(last, last)};
}

}  // namespace

double largestEigenvalue(const SymmetricOperator& multiply, Eigen::Index size, double tolerance) {
  const Eigen::Index steps = std::min(size, kMaxSteps);
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
    const bool exhausted = coupling[k] <= kExhausted * scale;
    if (!exhausted && k + 1 < steps && (k + 1) % kStepsBetweenChecks != 0) continue;
    const Ritz ritz = solve(diagonal.head(k + 1), coupling.head(k), scale);
    largest = ritz.largest;
    const double residual = coupling[k] * std::abs(ritz.lastEntry);
    if (exhausted || residual <= tolerance * std::abs(largest)) break;
  }
  return largest;
}

}  // namespace limber
