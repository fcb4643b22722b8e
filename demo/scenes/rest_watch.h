// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/soft_body_system.h>

#include <Eigen/Geometry>

#include <cstdint>
#include <vector>

namespace limber::scenes {

/// How far points have moved of late. Positions tell whether a body is calm; velocities do not: those of a
/// body that rests on a floor carry the phase of its substeps.
///
/// Keeps the box each point has stayed in, for the present half second and for the one before it.
class RestWatch {
 public:
  static constexpr std::int64_t kWindowTicks = 30;

  /// Call once after every tick.
  void look(const SoftBodySystem& soft);

  /// m, the largest diagonal of a point's box in the last half to whole second; infinite before the first
  /// half second is over, and for points that are not finite.
  double largestMotion() const;
  /// The same for the points of one body.
  double largestMotion(std::size_t body) const;

 private:
  using Boxes = std::vector<Eigen::AlignedBox3d>;

  std::vector<std::size_t> firstPoint_;  // #bodies + 1
  Boxes present_, before_;               // #points of all bodies
  std::int64_t ticks_ = 0;
};

}  // namespace limber::scenes
