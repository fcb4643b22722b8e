// SPDX-License-Identifier: Zlib
#pragma once

// Bones that carry points of a soft body, such as the clothes of an animated character.

#include <limber/bullet_precision.h>
#include <limber/export.h>
#include <limber/handle.h>
#include <limber/result.h>
#include <limber/soft_body.h>
#include <limber/soft_body_system.h>
#include <limber/spring_constraint.h>

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
  double maxDistance = 0.0;  ///< m, 0 to 1e6, how far the point may be from its place; 0: it is pinned there
  double backStop = -1.0;    ///< m, how far it may be behind its place; below 0 (the default): maxDistance.
                             ///< Behind is against the normal of the body's surface when it was bound, which
                             ///< turns with the bones.
};

/// Moves points of a soft body with the bones of an animation, by linear blend skinning: the place of a point
/// at x when it was bound is  sum w_b T_b T_b0^-1 x,  with the transforms T_b0 of the bones then and T_b now.
///
/// Points with a maxDistance move freely about their places. Springs hold them where they reach that
/// distance, or the back stop: a sphere of ten times that distance with its surface behind the place. (So do
/// the motion and separation constraints of NvCloth.) The springs have the body's extensionStiffness; they
/// give way as the body's own springs do. All other points follow by the body's springs. Thread rule: as for
/// SoftBody.
///
///     auto skeleton = limber::Skeleton::bind(soft, *shirt, {{0, {{kSpine, 1.0}}},
///                                            {7, {{kSpine, 0.4}, {kArm, 0.6}}, 0.05, 0.0}}, bones);
///     skeleton->moveTo(bones);  // before each step of the world
class LIMBER_API Skeleton {
 public:
  Skeleton(Skeleton&&) = default;
  Skeleton& operator=(Skeleton&& other) noexcept;
  /// Removes its springs. Its pins stay.
  ~Skeleton();

  /// Binds points of a body of the system at their present places. Errors, with nothing bound, name the bound
  /// point: no such point or bone, a point that is bound twice or was deleted, weights below 0 or with
  /// another sum, distances out of range, a back stop without a maxDistance or without a surface; or the
  /// bone: one that is not finite, farther than 1e6 m or without an inverse.
  static Result<Skeleton> bind(SoftBodySystem& system, SoftBody& body, const std::vector<BoundPoint>& points,
                               const std::vector<btTransform>& bones);

  /// Moves the places to the bones over the next tick. With `teleport` at once, and the whole body with them:
  /// by the rigid motion that is nearest to that of the places; it gives no velocity. Errors: another number
  /// of bones than bound, one that is not finite or farther than 1e6 m, those of SoftBody::movePin(), a body
  /// that has been destroyed.
  Result<void> moveTo(const std::vector<btTransform>& bones, bool teleport = false);

  /// Returns the place (m) of bound point i, in the order of bind(), where moveTo() has last put it; 0 if
  /// there is no such point.
  btVector3 place(std::size_t i) const {
    return i < followers_.size() ? followers_[i].place : btVector3(0, 0, 0);
  }

  /// Unpins all points and removes the springs.
  void release();

 private:
  struct Part {
    std::size_t bone;
    btScalar weight;
    btVector3 place, normal;  ///< in the bone's coordinates
  };
  struct Follower {
    std::uint32_t point;
    std::vector<Part> parts;
    btScalar maxDistance, backStop;
    btVector3 place;
    Handle<SpringConstraint> limit, stop;
  };
  Skeleton() = default;
  static Follower follow(const SoftBody& body, const BoundPoint& bound, const btVector3& normal,
                         const std::vector<btTransform>& bones);
  static btVector3 stopOf(const Follower& follower, const std::vector<btTransform>& bones);
  Result<void> hold(Follower& follower, const std::vector<btTransform>& bones);
  Result<void> carry(const Follower& follower, const std::vector<btTransform>& bones, bool teleport);
  Result<void> carryPin(const Follower& follower, bool teleport);
  Result<void> teleportBody(const std::vector<btVector3>& to);
  void removeSprings();

  SoftBodySystem* system_ = nullptr;  // exists as long as one of the springs does
  Handle<SoftBody> body_;
  std::size_t bones_ = 0;
  std::vector<Follower> followers_;
};

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
