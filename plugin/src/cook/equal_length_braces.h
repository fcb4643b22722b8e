// SPDX-License-Identifier: Zlib
#pragma once

#include "mesh/edges.h"

#include <Eigen/Core>

#include <vector>

namespace limber {

/// All pairs of points that are no edge but as far apart as the ends of some edge, sorted. `edges` must be
/// sorted and unique.
std::vector<Edge> findEqualLengthPairs(const std::vector<Eigen::Vector3d>& points,
                                       const std::vector<Edge>& edges);

}  // namespace limber
