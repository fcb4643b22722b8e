// SPDX-License-Identifier: Zlib
// Compiles the decompositions of Eigen that are used; computes the largest eigenvalue by Lanczos iteration.
#include "mesh/linear_algebra.h"

#include "mesh/random.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/OrderingMethods>

#include <algorithm>
#include <cmath>

namespace limber {
namespace {

constexpr double kNegligibleEigenvalue = 1e-14;

/// Eigenvalues of a rotation's matrix that differ by less than this share of the largest are the same: points
/// in single precision are on a line to about this.
constexpr double kSameEigenvalue = 1e-5;

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

Eigen::Matrix3d pseudoInverse(const Eigen::Matrix3d& matrix) {
  const SymmetricParts3 parts = symmetricParts3(matrix);
  const double limit = kNegligibleEigenvalue * parts.values.cwiseAbs().maxCoeff();
  Eigen::Matrix3d inverse = Eigen::Matrix3d::Zero();
  for (int k = 0; k < 3; ++k)
    if (std::abs(parts.values[k]) > limit)
      inverse += parts.vectors.col(k) * parts.vectors.col(k).transpose() / parts.values[k];
  return inverse;
}

Eigen::MatrixXd quaternionMatrix(const Eigen::Matrix3d& sum) {
  const Eigen::Vector3d twist(sum(1, 2) - sum(2, 1), sum(2, 0) - sum(0, 2), sum(0, 1) - sum(1, 0));
  Eigen::MatrixXd matrix(4, 4);
  matrix << sum.trace(), twist.transpose(), twist,
      Eigen::Matrix3d(sum + sum.transpose() - sum.trace() * Eigen::Matrix3d::Identity());
  return matrix;
}

Eigen::Isometry3d rigidMotionBetween(const Eigen::Matrix3Xd& from, const Eigen::Matrix3Xd& to) {
  const Eigen::Vector3d fromMean = from.rowwise().mean(), toMean = to.rowwise().mean();
  Eigen::Matrix3d s = Eigen::Matrix3d::Zero();
  for (Eigen::Index i = 0; i < from.cols(); ++i)
    s += (from.col(i) - fromMean) * (to.col(i) - toMean).transpose();
  const SymmetricParts parts = symmetricParts(quaternionMatrix(s));
  // of several best ones, as for points on a line, the one that turns least
  Eigen::Vector4d q = Eigen::Vector4d::Zero();
  for (int k = 0; k < 4; ++k)
    if (parts.values[3] - parts.values[k] <= kSameEigenvalue * parts.values[3])
      q += parts.vectors(0, k) * parts.vectors.col(k);
  if (q.norm() < kSameEigenvalue) q = parts.vectors.col(3);
  Eigen::Isometry3d motion(Eigen::Quaterniond(q[0], q[1], q[2], q[3]).normalized());
  motion.translation() = toMean - motion.linear() * fromMean;
  return motion;
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

Eigen::VectorXi sparseOrder(const Eigen::SparseMatrix<double>& matrix) {
  const Eigen::SparseMatrix<double> both = matrix.selfadjointView<Eigen::Lower>();
  Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, int> order;
  Eigen::AMDOrdering<int>()(both, order);
  return order.inverse().eval().indices();
}

// Columns of L next to each other with the same rows below them are a supernode. They are eliminated together
// in a dense matrix, their front: the sum of their entries of A and of what the supernodes before them leave
// (the multifrontal method: I. Duff, J. Reid, The Multifrontal Solution of Indefinite Sparse Symmetric Linear
// Equations, 1983). Nearly all of the work is in products of dense matrices.

namespace {

using Index = Eigen::Index;
using Sparse = Eigen::SparseMatrix<double>;
using Indices = std::vector<int>;

struct Supernode {
  int first = 0, end = 0;         ///< its columns
  Indices rows;                   ///< of its front, ascending: its own columns, then the rows below them
  std::vector<std::size_t> from;  ///< the supernodes whose rest is a part of its front
  Eigen::MatrixXd rest;           ///< what it leaves for the rows below, until that is taken

  Index width() const { return end - first; }
  Index height() const { return static_cast<Index>(rows.size()); }
};

/// Returns the lower triangle of  P A P^T.
Sparse reordered(const Sparse& matrix, const Eigen::VectorXi& place) {
  std::vector<Eigen::Triplet<double>> entries;
  entries.reserve(static_cast<std::size_t>(matrix.nonZeros()));
  for (Index j = 0; j < matrix.cols(); ++j)
    for (Sparse::InnerIterator entry(matrix, j); entry; ++entry)
      if (entry.row() >= j) {
        const auto [low, high] = std::minmax(place[entry.row()], place[j]);
        entries.emplace_back(high, low, entry.value());
      }
  Sparse result(matrix.rows(), matrix.cols());
  result.setFromTriplets(entries.begin(), entries.end());
  return result;
}

/// The first row below each column of L, which is its parent in the elimination tree (J. Liu, The Role of
/// Elimination Trees in Sparse Factorization, 1990), and the number of those rows.
struct EliminationTree {
  Indices parent, below;
};

EliminationTree eliminationTree(const Sparse& lower) {
  const Sparse rows = lower.transpose();
  const auto size = static_cast<std::size_t>(lower.cols());
  EliminationTree tree{Indices(size, -1), Indices(size, 0)};
  Indices lastRow(size, -1);
  for (int row = 0; row < lower.rows(); ++row)
    for (Sparse::InnerIterator entry(rows, row); entry && entry.row() < row; ++entry)
      for (auto j = std::size_t(entry.row()); int(j) != row && lastRow[j] != row;
           j = std::size_t(tree.parent[j])) {
        if (tree.parent[j] < 0) tree.parent[j] = row;
        ++tree.below[j];
        lastRow[j] = row;
      }
  return tree;
}

/// Returns the supernodes in the order of their columns, with the rows of their fronts.
std::vector<Supernode> supernodesOf(const Sparse& lower) {
  const EliminationTree tree = eliminationTree(lower);
  std::vector<Supernode> nodes;
  std::vector<std::size_t> nodeOf(static_cast<std::size_t>(lower.cols()));
  for (std::size_t j = 0; j < nodeOf.size(); ++j) {
    if (j == 0 || tree.parent[j - 1] != int(j) || tree.below[j - 1] != tree.below[j] + 1)
      nodes.push_back({int(j), int(j), {}, {}, {}});
    nodes.back().end = int(j) + 1;
    nodeOf[j] = nodes.size() - 1;
  }
  for (std::size_t n = 0; n < nodes.size(); ++n) {
    Supernode& node = nodes[n];
    for (int j = node.first; j < node.end; ++j) {
      node.rows.push_back(j);
      for (Sparse::InnerIterator entry(lower, j); entry; ++entry) node.rows.push_back(int(entry.row()));
    }
    for (const std::size_t child : node.from)
      node.rows.insert(node.rows.end(), nodes[child].rows.begin() + nodes[child].width(),
                       nodes[child].rows.end());
    std::sort(node.rows.begin(), node.rows.end());
    node.rows.erase(std::unique(node.rows.begin(), node.rows.end()), node.rows.end());
    if (node.height() > node.width())
      nodes[nodeOf[std::size_t(node.rows[std::size_t(node.width())])]].from.push_back(n);
  }
  return nodes;
}

/// Returns the lower triangle of the front; all else is 0. `rowAt` is scratch: the place of a row in it.
Eigen::MatrixXd assembled(Supernode& node, std::vector<Supernode>& nodes, const Sparse& lower,
                          Indices& rowAt) {
  for (std::size_t i = 0; i < node.rows.size(); ++i) rowAt[std::size_t(node.rows[i])] = int(i);
  Eigen::MatrixXd front = Eigen::MatrixXd::Zero(node.height(), node.height());
  for (int j = node.first; j < node.end; ++j)
    for (Sparse::InnerIterator entry(lower, j); entry; ++entry)
      front(rowAt[std::size_t(entry.row())], j - node.first) = entry.value();
  for (const std::size_t from : node.from) {
    Supernode& child = nodes[from];
    const int* const rows = child.rows.data() + child.width();
    for (Index j = 0; j < child.rest.cols(); ++j) {
      double* const column = front.col(rowAt[std::size_t(rows[j])]).data();
      for (Index i = j; i < child.rest.rows(); ++i) column[rowAt[std::size_t(rows[i])]] += child.rest(i, j);
    }
    child.rest.resize(0, 0);
  }
  return front;
}

/// Columns that are eliminated before all columns after them are updated at once, and columns of which one
/// product updates the lower triangle.
constexpr Index kPanel = 32, kUpdated = 64;

/// Eliminates the first `width` columns of the front, which become those of  L D.
void eliminate(Eigen::MatrixXd& front, Index width) {
  const Index size = front.rows();
  Eigen::MatrixXd scaled;  // the panel's columns of L
  for (Index first = 0; first < width; first += kPanel) {
    const Index end = std::min(first + kPanel, width);
    for (Index k = first; k < end; ++k)
      for (Index j = k + 1; j < end; ++j)
        front.col(j).tail(size - j) -= front(j, k) / front(k, k) * front.col(k).tail(size - j);
    scaled = front.block(end, first, size - end, end - first);
    for (Index k = first; k < end; ++k) scaled.col(k - first) /= front(k, k);
    for (Index j = end; j < size; j += kUpdated) {
      const Index columns = std::min(kUpdated, size - j);
      front.block(j, j, size - j, columns).noalias() -=
          scaled.bottomRows(size - j) * front.block(j, first, columns, end - first).transpose();
    }
  }
}

/// Appends the front's first columns to those of the factor.
void store(const Supernode& node, const Eigen::MatrixXd& front, SparseFactor& factor) {
  for (Index k = 0; k < node.width(); ++k) {
    const Index j = node.first + k, at = factor.lower.outerIndexPtr()[j], count = node.height() - k - 1;
    factor.diagonal[j] = front(k, k);
    std::copy_n(node.rows.begin() + k + 1, count, factor.lower.innerIndexPtr() + at);
    for (Index i = 0; i < count; ++i) factor.lower.valuePtr()[at + i] = front(k + 1 + i, k) / front(k, k);
  }
}

void reserve(SparseFactor& factor, const std::vector<Supernode>& nodes, Index size) {
  factor.lower.resize(size, size);
  factor.diagonal.setZero(size);
  Index entries = 0;
  for (const Supernode& node : nodes)
    for (Index k = 0; k < node.width(); ++k) {
      entries += node.height() - k - 1;
      factor.lower.outerIndexPtr()[node.first + k + 1] = static_cast<int>(entries);
    }
  factor.lower.resizeNonZeros(entries);
}

}  // namespace

SparseFactor factorise(const Sparse& matrix) {
  SparseFactor factor;
  factor.place = sparseOrder(matrix);
  const Sparse lower = reordered(matrix, factor.place);
  std::vector<Supernode> nodes = supernodesOf(lower);
  reserve(factor, nodes, matrix.rows());
  Indices rowAt(static_cast<std::size_t>(matrix.rows()));
  for (Supernode& node : nodes) {
    Eigen::MatrixXd front = assembled(node, nodes, lower, rowAt);
    eliminate(front, node.width());
    store(node, front, factor);
    const Index below = node.height() - node.width();
    node.rest = front.bottomRightCorner(below, below);
  }
  factor.isComplete = (factor.diagonal.array() != 0.0).all();
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

/// The result for the tridiagonal matrix with `diagonal` (n) and `coupling` (n - 1) next to it, whose entries
/// are `scale` at most.
struct Ritz {
  double largest, lastEntry;  ///< its largest eigenvalue, and the last entry of the eigenvector
};

Ritz solve(const Eigen::VectorXd& diagonal, const Eigen::VectorXd& coupling, double scale) {
  const double unit = scale > kHuge ? scale : 1.0;
  DenseSolver solver;
  solver.computeFromTridiagonal(diagonal / unit, coupling / unit);
  const Eigen::Index last = diagonal.size() - 1;
  return {solver.eigenvalues()[last] * unit, solver.eigenvectors()(last, last)};
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
