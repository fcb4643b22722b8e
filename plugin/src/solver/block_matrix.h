// SPDX-License-Identifier: Zlib
#pragma once

// Sparse symmetric matrices of 3 x 3 blocks, and their factors.

#include <Eigen/Core>

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace limber {

using PointPair = std::array<std::uint32_t, 2>;

/// A symmetric positive definite matrix A with a block for each pair of joined points, or its factors
///     P A P^T = L D L^T,   D of 3 x 3 blocks, L with unit blocks on its diagonal.
/// The permutation P keeps L sparse. Blocks are in the order of P, and those that the factorisation fills are
/// there from the start.
struct BlockMatrix {
  std::vector<std::uint32_t> place;    ///< #points, the row and column of each point
  std::vector<std::uint32_t> start;    ///< #points + 1, the first block of each column in `row` and `below`
  std::vector<std::uint32_t> row;      ///< #blocks below the diagonal, ascending in a column
  std::vector<Eigen::Matrix3d> below;  ///< the same, of A or L
  std::vector<Eigen::Matrix3d> diagonal;  ///< #points, of A, or the inverse blocks of D
  std::vector<Eigen::Matrix3d> column;    ///< scratch

  std::size_t points() const { return diagonal.size(); }
  /// Adds to A the block in the row of point i and the column of point j, which are joined or equal.
  void add(std::uint32_t i, std::uint32_t j, const Eigen::Matrix3d& block);
};

/// Returns the number of blocks below the diagonal in each column of the factors.
std::vector<std::uint32_t> fillOf(const std::vector<PointPair>& joined, std::size_t points);

/// Sets the pattern. Pairs may be repeated.
void setPattern(BlockMatrix& matrix, const std::vector<PointPair>& joined, std::size_t points);

void setZero(BlockMatrix& matrix);

/// Replaces A by its factors; allocates nothing. A pivot of 0 or less, which rounding can cause, becomes 1.
void factorise(BlockMatrix& matrix);

/// Solves A x = b in place with the factors. `x`: 3 x #points, in the order of the points.
void solve(const BlockMatrix& factors, Eigen::Matrix3Xd& x, Eigen::Matrix3Xd& scratch);

}  // namespace limber
