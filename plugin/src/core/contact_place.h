// SPDX-License-Identifier: Zlib
#pragma once

#include "core/links.h"

#include <array>
#include <cstdint>

namespace limber {

/// A place on the surface of a body: on a soft one a point mass or a place between two or three, on a rigid
/// one a place off its centre of mass, or one that nothing moves but as told.
struct ContactPlace {
  enum class Kind : std::uint8_t { Soft, Rigid, World } kind = Kind::World;
  std::uint32_t body = 0;                              ///< index into the group's points or rigids
  std::uint32_t count = 1;                             ///< of a Soft: how many points, 1 to 3
  std::array<std::uint32_t, 3> point{};                ///< of a Soft
  std::array<double, 3> weight{1.0};                   ///< of a Soft, sum 1
  Eigen::Vector3d arm = Eigen::Vector3d::Zero();       ///< of a Rigid: m, from its centre, world axes
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();  ///< of the World: m/s, constant over the tick
};

/// 1/kg, 3 x 3: the velocity change there per impulse there, of a Rigid.
Eigen::Matrix3d mobility(const LinkedBodies& bodies, const ContactPlace& place);

}  // namespace limber
