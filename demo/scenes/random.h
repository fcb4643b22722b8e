// SPDX-License-Identifier: Zlib
#pragma once

#include <Eigen/Geometry>

#include <cstdint>
#include <random>

namespace limber::scenes {

/// Numbers that depend on the seed alone. The standard fixes the engine's output but not that of its
/// distributions, so the mapping to numbers is our own.
class Random {
 public:
  explicit Random(std::uint64_t seed) : engine_(seed) {}

  /// Uniform in [0, 1).
  double unit() { return static_cast<double>(engine_() >> 11) * 0x1p-53; }
  /// Uniform in [low, high).
  double between(double low, double high) { return low + (high - low) * unit(); }
  /// Uniform over all rotations (Shoemake 1992).
  Eigen::Quaterniond rotation();

 private:
  std::mt19937_64 engine_;
};

}  // namespace limber::scenes
