// SPDX-License-Identifier: Zlib
#pragma once

// Bones that carry points of a soft body, such as the clothes of an animated character.

#include <limber/bullet_precision.h>
#include <limber/handle.h>
#include <limber/result.h>
#include <limber/soft_body.h>

#include <btBulletDynamicsCommon.h>

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

/// A point that bones carry.
struct BoundPoint {
  std::uint32_t point = 0;
  std::vector<std::pair<std::size_t, double>> weights;  ///< bones and their weights, 0 or more, sum 1
};

/// Moves points of a soft body with the bones of an animation, by linear blend skinning: a point at x when it
/// was bound is at  sum w_b T_b T_b0^-1 x,  with the transforms T_b0 of the bones then and T_b now. Bound
/// points are pinned; the others follow by their springs. Its pins stay when it is destroyed. Thread rule: as
/// for SoftBody.
///
///     auto skeleton = limber::Skeleton::bind(*shirt, {{0, {{kSpine, 1.0}}}, {7, {{kSpine, 0.4}, {kArm,
///     0.6}}}},
///                                            bones);
///     skeleton->moveTo(bones);  // before each step of the world
class Skeleton {
 public:
  /// Binds points at their present places. Errors, with nothing pinned, name the bound point: no such point
  /// or bone, weights below 0 or with another sum.
  static Result<Skeleton> bind(SoftBody& body, const std::vector<BoundPoint>& points,
                               const std::vector<btTransform>& bones);

  /// Moves the points to the bones over the next tick; at once and without velocity if `teleport`. Errors:
  /// another number of bones than bound, those of SoftBody::movePin(), a body that has been destroyed.
  Result<void> moveTo(const std::vector<btTransform>& bones, bool teleport = false);

  /// Unpins all points.
  void release();

 private:
  struct Part {
    std::size_t bone;
    btScalar weight;
    btVector3 local;  ///< place in the bone's coordinates
  };
  struct Follower {
    std::uint32_t point;
    std::vector<Part> parts;
  };
  static btVector3 placeOf(const Follower& follower, const std::vector<btTransform>& bones);

  Handle<SoftBody> body_;
  std::size_t bones_ = 0;
  std::vector<Follower> followers_;
};

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
