// SPDX-License-Identifier: Zlib
#pragma once

#include <Eigen/Core>

#include <cstdint>
#include <vector>

namespace limber {

/// For each position the index of the position it joins, never a later one; a position that joins none keeps
/// its own index. #positions entries. Both expect finite positions.

/// Joins equal positions (-0 equals 0) to the first of them.
std::vector<std::uint32_t> mergeEqual(const std::vector<Eigen::Vector3d>& positions);

/// Goes through the positions in order: each joins the nearest one kept so far within `tolerance` (the first
/// of equally near ones), or is kept itself. The tolerance must be above 0.
std::vector<std::uint32_t> mergeNearby(const std::vector<Eigen::Vector3d>& positions, double tolerance);

}  // namespace limber
