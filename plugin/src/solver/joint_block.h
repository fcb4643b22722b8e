// SPDX-License-Identifier: Zlib
#pragma once

// A direct solve of the joints' rows that hold in both directions. Sweeps that solve one row after the other
// take dozens to bring an impulse from one end of a chain to the other, and hundreds where it is taut.

#include <cstdint>
#include <vector>

namespace limber {

struct JointConstraint;
struct LinkedBodies;

/// The rows of the block, and the factors L D L^T of their matrix A = J M^-1 J^T. L is stored from the first
/// column of each row that is not 0: few, if the rows of bodies that are joined follow each other.
struct JointBlock {
  std::vector<std::uint32_t> rows;   ///< #n, indices of joints
  std::vector<std::uint32_t> first;  ///< #n, first column
  std::vector<std::size_t> begin;    ///< #n + 1, place of that column in `lower`
  std::vector<double> lower;         ///< L
  std::vector<double> pivots;        ///< #n, D; 0: the row depends on those before and is left out
  std::vector<double> diagonal;      ///< #n, of A
  std::vector<double> change;        ///< #n, right side, then impulses
};

/// Lists the rows of the block, and marks them. Call it where joints have been added; none are listed if the
/// block would be too large to pay.
void listBlock(std::vector<JointConstraint>& joints, JointBlock& block);

/// Factors the matrix of the present rows and poses. `softness`: relative to the diagonal.
void factorBlock(const std::vector<JointConstraint>& joints, const LinkedBodies& bodies, double softness,
                 JointBlock& block);

/// Replaces block.change by the solution.
void solveBlock(JointBlock& block);

}  // namespace limber
