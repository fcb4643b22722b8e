// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/bullet_precision.h>
#include <limber/export.h>
#include <limber/handle.h>
#include <limber/soft_body_settings.h>

#include <btBulletDynamicsCommon.h>

#include <memory>
#include <optional>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

struct GrabPull;

/// The attachment of one end of a spring: a rigid body with a pivot in its local coordinates, a point mass of
/// a soft body (SoftBody::point(i), pivot 0), or a fixed point in the world (no body, the pivot in world
/// coordinates).
struct SpringEnd {
  btRigidBody* body = nullptr;
  btVector3 pivot = btVector3(0, 0, 0);
};

/// A single spring between two ends, created by SoftBodySystem::addSpring(). It is stepped within the tick
/// together with the bodies it is attached to, so its stiffness is in SI units and it is always stable.
/// Thread rule: as for SoftBodySystem.
class LIMBER_API SpringConstraint {
 public:
  SpringConstraint(const SpringConstraint&) = delete;
  SpringConstraint& operator=(const SpringConstraint&) = delete;

  /// Returns a reference that becomes null when the spring is removed.
  Handle<SpringConstraint> handle();

  const SpringEnd& endA() const { return a_; }
  const SpringEnd& endB() const { return b_; }
  const SpringSettings& settings() const { return settings_; }

  /// Returns where the end that is fixed in the world moves over the next tick, if it does.
  const std::optional<btVector3>& target() const { return target_; }

  /// Returns the current distance of its ends, m.
  btScalar length() const { return (worldPivot(a_) - worldPivot(b_)).length(); }

  /// Returns the position of an end in the world.
  static btVector3 worldPivot(const SpringEnd& end) {
    return end.body ? end.body->getWorldTransform() * end.pivot : end.pivot;
  }

  /// Returns the force of the spring without its damper at the end of the last tick, N; above 0 it pulls the
  /// ends together.
  double force() const { return force_; }

  /// Returns whether it has broken (SpringSettings::breakForce). It then has no force, but exists until it is
  /// removed; SoftBodySystem::changeSpring() mends it.
  bool broken() const { return broken_; }

 private:
  friend class SoftBodySystem;
  friend class Skeleton;
  friend class Grab;
  SpringConstraint(const SpringEnd& a, const SpringEnd& b, const SpringSettings& settings)
      : a_(a), b_(b), settings_(settings) {}

  SpringEnd a_, b_;
  std::optional<btVector3> target_;  // where the end in the world goes in the next tick
  SpringSettings settings_;
  double force_ = 0.0;
  bool broken_ = false;
  std::shared_ptr<GrabPull> grab_;    // that holds a point by it: it is not a part of saved states
  std::shared_ptr<const void> life_;  // expires with the spring; nullptr until there is a handle
};

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
