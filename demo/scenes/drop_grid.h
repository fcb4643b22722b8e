// SPDX-License-Identifier: Zlib
#pragma once

#include "scenes/random.h"

#include <Eigen/Geometry>

#include <cstdint>
#include <vector>

namespace limber::scenes {

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
