// SPDX-License-Identifier: Zlib
#pragma once

#include <Eigen/Core>

#include <vector>

namespace limber {

/// Mass, first moments (3), second moments (6).
using MomentVector = Eigen::Matrix<double, 10, 1>;

struct MomentMatch {
  std::vector<double> shares;  ///< #points, sum 1
  MomentVector misfit = MomentVector::Zero();
  /// Proven: no shares within the bounds come nearer to the target than this (Euclidean distance of the
  /// moments, mass included). Above 0 the problem has no solution.
  double leastMisfit = 0.0;
};

/// Shares of sum 1 between `least` (below 1 / #points) and most[i], nearest to those `wanted` by
/// sum (share - wanted)^2 / wanted,  whose moments  sum share_i momentsOfPoint_i  are `target`. Where there
/// are none: those whose moments err least, the first ones counting far more than the second. All moments
/// should be of the order of 1.
MomentMatch matchMoments(const std::vector<MomentVector>& momentsOfPoint, const MomentVector& target,
                         const std::vector<double>& wanted, double least, const std::vector<double>& most);

}  // namespace limber
