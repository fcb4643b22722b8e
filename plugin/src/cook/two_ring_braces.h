// SPDX-License-Identifier: Zlib
#pragma once

#include "mesh/edges.h"

#include <vector>

namespace limber {

/// All pairs of the `points` points that share a neighbour and are no edge themselves, sorted. `edges` must
/// be sorted and unique.
std::vector<Edge> findTwoRingPairs(std::size_t points, const std::vector<Edge>& edges);

}  // namespace limber
