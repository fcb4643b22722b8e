// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/network_analysis.h>

namespace limber {

/// Lets the network go from `runs` seeded deformations of this kind, lightly damped, with the volume term a
/// body of it would have, and counts those that come back. Run i depends on (kind, seed, i) alone. `progress`
/// may be empty; when it returns false the runs done so far are returned.
ReturnRate measureReturns(const SpringNetwork& network, Deformation kind, std::uint32_t runs,
                          std::uint64_t seed, const Progress& progress = {});

}  // namespace limber
