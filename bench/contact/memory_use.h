// SPDX-License-Identifier: Zlib
#pragma once

#include <optional>
#include <string>

namespace limber::bench {

/// Bytes that Limber's bodies take in a world after some ticks in free flight: Bullet's own for the points
/// and the allocator's overhead included, the network that they share left out.
struct MemoryUse {
  double perPoint = 0.0, perSpring = 0.0, perBody = 0.0;
  double networkPerSpring = 0.0;  ///< of a network, which all bodies of one shape share
};

/// From bodies that differ in points or springs alone. Empty where the C library does not tell (not glibc).
std::optional<MemoryUse> measureMemory(bool quick);

std::string describe(const std::optional<MemoryUse>& use);

}  // namespace limber::bench
