// SPDX-License-Identifier: Zlib
#pragma once

#include <Eigen/Core>

#include <cstdint>

namespace limber {

/// SplitMix64 (Steele, Lea, Flood 2014). It gives the same numbers on all platforms; the distributions of the
/// standard library do not guarantee this.
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}

  std::uint64_t next() {
    state_ += 0x9e3779b97f4a7c15u;
    std::uint64_t z = state_;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
  }

  /// Returns a number from 0 to 1, without 1.
  double uniform() { return static_cast<double>(next() >> 11) * 0x1p-53; }

  /// Returns 0 to count - 1. The bias of the remainder is below 1e-10 for all counts that fit in memory.
  std::uint32_t below(std::size_t count) { return static_cast<std::uint32_t>(next() % count); }

  /// Returns a point with uniform distribution in the unit ball.
  Eigen::Vector3d inBall() {
    for (;;) {
      const double x = uniform(), y = uniform(), z = uniform();
      Eigen::Vector3d v = 2.0 * Eigen::Vector3d(x, y, z) - Eigen::Vector3d::Ones();
      if (v.squaredNorm() <= 1.0) return v;
    }
  }

  /// Returns a point with uniform distribution on the unit sphere.
  Eigen::Vector3d direction() {
    for (;;) {
      const Eigen::Vector3d v = inBall();
      if (v.squaredNorm() > 1e-4) return v.normalized();
    }
  }

 private:
  std::uint64_t state_;
};

}  // namespace limber
