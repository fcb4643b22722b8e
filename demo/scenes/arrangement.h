// SPDX-License-Identifier: Zlib
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <cstddef>
#include <cstdint>
#include <random>
#include <vector>

namespace limber::scenes {

/// Random numbers that depend on the seed only. The C++ standard defines the output of the engine but not
/// that of its distributions, so the conversion is done here.
class Random {
 public:
  explicit Random(std::uint64_t start) : engine_(start) {}

  /// Uniform in [0, 1).
  double unit() { return static_cast<double>(engine_() >> 11) * 0x1p-53; }
  /// Uniform in [low, high).
  double between(double low, double high) { return low + (high - low) * unit(); }
  /// Returns a uniformly distributed rotation (Shoemake 1992).
  Eigen::Quaterniond rotation();

 private:
  std::mt19937_64 engine_;
};

/// Returns colour i of a small palette, sRGB, 0 to 1; the palette repeats.
Eigen::Vector3f paletteColour(std::size_t i);

/// Returns the same colour, a little lighter or darker.
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

/// Returns a grid for bodies of this size and radius (m), whose neighbours do not touch, whatever their
/// rotation.
DropGridSettings dropGridOf(std::uint32_t count, double size, double radius);

/// Returns the number of columns of a square grid for `count` bodies.
std::uint32_t gridColumns(std::uint32_t count);

/// Returns placements on a square grid in x and z around the origin, with random heights and rotations. No
/// two are above each other.
std::vector<Placement> dropGrid(const DropGridSettings& settings, Random& random);

}  // namespace limber::scenes
