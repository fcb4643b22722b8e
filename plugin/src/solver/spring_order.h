// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/spring_network.h>

#include <cstdint>
#include <vector>

namespace limber {

/// An order of the network's springs in which, as far as it can be, no two of each four in a row (0 to 3, 4
/// to 7, ...) share a point: their dampers can then be computed at once. Neighbours stay near each other.
std::vector<std::uint32_t> orderApart(const SpringNetwork& network);

}  // namespace limber
