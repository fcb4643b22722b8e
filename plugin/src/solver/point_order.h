// SPDX-License-Identifier: Zlib
#pragma once

#include "solver/springs.h"

#include <cstdint>
#include <vector>

namespace limber {

/// place[i]: where point i stands in an order in which points that springs join stand close together
/// (Cuthill, McKee 1969, reversed). For a rope it is the rope's own order, for a cloth row after row.
std::vector<std::uint32_t> bandOrder(const SpringArrays& springs, std::size_t points);

/// Largest distance of two joined points in that order.
std::size_t bandWidth(const SpringArrays& springs, const std::vector<std::uint32_t>& place);

}  // namespace limber
