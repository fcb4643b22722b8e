// SPDX-License-Identifier: Zlib
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <cstddef>
#include <cstdint>
#include <random>
#include <vector>

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

/// The i-th of a few colours that go well together, sRGB, 0 to 1; repeats.
Eigen::Vector3f paletteColour(std::size_t i);

/// The same, a little lighter or darker.
Eigen::Vector3f variedColour(std::size_t i, Random& random);

struct Placement {
  Eigen::Vector3d centre;  ///< m
  Eigen::Quaterniond rotation;
};

struct DropGridSettings {
  std::uint32_t count = 1;
  double spacing = 1.0;  ///< m between neighbours in x and z
  double lowest = 1.0;   ///< m, height of the lowest centre
  double highest = 2.0;  ///< m
};

/// Columns of the square that holds `count` bodies.
std::uint32_t gridColumns(std::uint32_t count);

/// Places over a square in x and z around the origin, at random heights, turned at random. No two are above
/// one another.
std::vector<Placement> dropGrid(const DropGridSettings& settings, Random& random);

}  // namespace limber::scenes
