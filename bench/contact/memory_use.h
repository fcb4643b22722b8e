// SPDX-License-Identifier: Zlib
#pragma once

#include <optional>
#include <string>

namespace limber::bench {

/// Bytes of Limber's bodies in a world after some ticks of free flight, with Bullet's objects for the points
/// and the overhead of the allocator, without the network, which bodies share.
struct MemoryUse {
  double perPoint = 0.0, perSpring = 0.0, perBody = 0.0;
  double networkPerSpring = 0.0;  ///< of a network, which all bodies of one shape share
};

/// Measures bodies that differ only in points or springs. Empty if the C library cannot report it (not
/// glibc).
std::optional<MemoryUse> measureMemory(bool quick);

std::string describe(const std::optional<MemoryUse>& use);

}  // namespace limber::bench
