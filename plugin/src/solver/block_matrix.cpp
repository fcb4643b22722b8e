// SPDX-License-Identifier: Zlib
#include "solver/block_matrix.h"

#include "mesh/linear_algebra.h"

#include <Eigen/SparseCore>

#include <algorithm>

namespace limber {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// The rows below the diagonal of each column of L.
using Columns = std::vector<std::vector<std::uint32_t>>;

/// Returns the place of each point in an order that keeps L sparse.
std::vector<std::uint32_t> sparseOrder(const std::vector<PointPair>& joined, std::size_t points) {
  std::vector<Eigen::Triplet<double>> entries;
  for (std::uint32_t i = 0; i < points; ++i) entries.emplace_back(i, i, 1.0);
  for (const PointPair& pair : joined)
    entries.emplace_back(std::max(pair[0], pair[1]), std::min(pair[0], pair[1]), 1.0);
  const auto size = static_cast<Eigen::Index>(points);
  Eigen::SparseMatrix<double> graph(size, size);
  graph.setFromTriplets(entries.begin(), entries.end());
  const Eigen::VectorXi place = limber::sparseOrder(graph);
  return {place.begin(), place.end()};
}

void addUnique(std::vector<std::uint32_t>& to, std::vector<std::uint32_t>& added) {
  to.insert(to.end(), added.begin(), added.end());
  std::sort(to.begin(), to.end());
  to.erase(std::unique(to.begin(), to.end()), to.end());
}

/// The elimination of a column joins its rows with each other: it suffices to add them to the column of the
/// first one.
Columns columnsOf(const std::vector<PointPair>& joined, const std::vector<std::uint32_t>& place) {
  Columns columns(place.size());
  for (const PointPair& pair : joined) {
    const auto [low, high] = std::minmax(place[pair[0]], place[pair[1]]);
    if (low != high) columns[low].push_back(high);
  }
  std::vector<std::uint32_t> rest;
  for (std::vector<std::uint32_t>& rows : columns) {
    rest.clear();
    addUnique(rows, rest);
    if (rows.empty()) continue;
    rest.assign(rows.begin() + 1, rows.end());
    addUnique(columns[rows[0]], rest);
  }
  return columns;
}

double pivot(double value) { return value > 0.0 ? value : 1.0; }

/// Returns the inverse of a symmetric block, with l d l^T as its factors.
Matrix3d inverseOf(const Matrix3d& a) {
  const double d0 = pivot(a(0, 0)), l10 = a(1, 0) / d0, l20 = a(2, 0) / d0;
  const double d1 = pivot(a(1, 1) - l10 * a(1, 0)), l21 = (a(2, 1) - l20 * a(1, 0)) / d1;
  const double d2 = pivot(a(2, 2) - l20 * a(2, 0) - l21 * l21 * d1);
  Matrix3d inverse = Matrix3d::Identity();
  inverse(1, 0) = -l10, inverse(2, 1) = -l21, inverse(2, 0) = l10 * l21 - l20;
  return inverse.transpose() * Vector3d(1.0 / d0, 1.0 / d1, 1.0 / d2).asDiagonal() * inverse;
}

}  // namespace

void BlockMatrix::add(std::uint32_t i, std::uint32_t j, const Matrix3d& block) {
  const std::uint32_t at = place[i], of = place[j];
  if (at == of) {
    diagonal[at] += block;
    return;
  }
  const auto [low, high] = std::minmax(at, of);
  const auto first = row.begin() + start[low], last = row.begin() + start[low + 1];
  Matrix3d& entry = below[static_cast<std::size_t>(std::lower_bound(first, last, high) - row.begin())];
  if (at == high)
    entry += block;
  else
    entry += block.transpose();
}

std::vector<std::uint32_t> fillOf(const std::vector<PointPair>& joined, std::size_t points) {
  std::vector<std::uint32_t> fill;
  for (const auto& rows : columnsOf(joined, sparseOrder(joined, points)))
    fill.push_back(static_cast<std::uint32_t>(rows.size()));
  return fill;
}

void setPattern(BlockMatrix& matrix, const std::vector<PointPair>& joined, std::size_t points) {
  matrix.place = sparseOrder(joined, points);
  matrix.start.assign(1, 0);
  matrix.row.clear();
  std::size_t most = 0;
  for (const auto& rows : columnsOf(joined, matrix.place)) {
    matrix.row.insert(matrix.row.end(), rows.begin(), rows.end());
    matrix.start.push_back(static_cast<std::uint32_t>(matrix.row.size()));
    most = std::max(most, rows.size());
  }
  matrix.below.resize(matrix.row.size());
  matrix.diagonal.resize(points);
  matrix.column.resize(most);
}

void setZero(BlockMatrix& matrix) {
  std::fill(matrix.below.begin(), matrix.below.end(), Matrix3d::Zero());
  std::fill(matrix.diagonal.begin(), matrix.diagonal.end(), Matrix3d::Zero());
}

/// Column j of A with the block d of D becomes column j of L = A d^-1. Each column k of its rows loses
/// L_k A_k^T, and below it L_i A_k^T.
void factorise(BlockMatrix& matrix) {
  for (std::size_t j = 0; j < matrix.points(); ++j) {
    const Matrix3d inverse = inverseOf(matrix.diagonal[j]);
    const std::size_t first = matrix.start[j], count = matrix.start[j + 1] - first;
    for (std::size_t a = 0; a < count; ++a) matrix.column[a].noalias() = matrix.below[first + a] * inverse;
    for (std::size_t b = 0; b < count; ++b) {
      const std::uint32_t k = matrix.row[first + b];
      const Matrix3d transposed = matrix.below[first + b].transpose();
      matrix.diagonal[k].noalias() -= matrix.column[b] * transposed;
      std::size_t to = matrix.start[k];
      for (std::size_t a = b + 1; a < count; ++a, ++to) {
        while (matrix.row[to] != matrix.row[first + a]) ++to;
        matrix.below[to].noalias() -= matrix.column[a] * transposed;
      }
    }
    std::copy_n(matrix.column.begin(), count, matrix.below.begin() + static_cast<std::ptrdiff_t>(first));
    matrix.diagonal[j] = inverse;
  }
}

void solve(const BlockMatrix& factors, Eigen::Matrix3Xd& x, Eigen::Matrix3Xd& scratch) {
  for (Eigen::Index i = 0; i < x.cols(); ++i)
    scratch.col(factors.place[static_cast<std::size_t>(i)]) = x.col(i);
  const std::size_t points = factors.points();
  for (std::size_t j = 0; j < points; ++j) {
    const Vector3d solved = scratch.col(static_cast<Eigen::Index>(j));
    for (std::size_t k = factors.start[j]; k < factors.start[j + 1]; ++k)
      scratch.col(factors.row[k]).noalias() -= factors.below[k] * solved;
  }
  for (std::size_t j = points; j-- > 0;) {
    Vector3d sum = factors.diagonal[j] * scratch.col(static_cast<Eigen::Index>(j));
    for (std::size_t k = factors.start[j]; k < factors.start[j + 1]; ++k)
      sum.noalias() -= factors.below[k].transpose() * scratch.col(factors.row[k]);
    scratch.col(static_cast<Eigen::Index>(j)) = sum;
  }
  for (Eigen::Index i = 0; i < x.cols(); ++i)
    x.col(i) = scratch.col(factors.place[static_cast<std::size_t>(i)]);
}

}  // namespace limber
