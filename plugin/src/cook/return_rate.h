// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/network_analysis.h>

namespace limber {

/// Never the seed itself: a network that was braced against the deformations of a seed must not be measured
/// on the same ones.
std::uint64_t measuringSeed(std::uint64_t seed);

/// Lets the network go from `runs` seeded deformations of this kind, lightly damped, with the volume term a
/// body of it would have, and counts those that come back. Run i depends on (kind, seed, i) alone. `progress`
/// may be empty; when it returns false the runs done so far are returned. No runs where they would say
/// nothing, see canRelax().
/// The seed of the deformations is measuringSeed(seed).
ReturnRate measureReturns(const SpringNetwork& network, Deformation kind, std::uint32_t runs,
                          std::uint64_t seed, const Progress& progress = {});

}  // namespace limber
