// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/bullet_precision.h>
#include <limber/spring_settings.h>

#include <btBulletDynamicsCommon.h>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

/// What one end of a spring holds on to: any rigid body of the world at a pivot in its local coordinates, a
/// point mass of a soft body (SoftBody::point(i), pivot 0), or a fixed place in the world (no body, the pivot
/// in world coordinates).
struct SpringEnd {
  btRigidBody* body = nullptr;
  btVector3 pivot = btVector3(0, 0, 0);
};

/// A single spring between two ends, made by SoftBodySystem::addSpring(). It is stepped within the tick
/// together with everything it is joined to, so its stiffness is in real units and never unstable.
class SpringConstraint {
 public:
  SpringConstraint(const SpringEnd& a, const SpringEnd& b, const SpringSettings& settings)
      : a_(a), b_(b), settings_(settings) {}

  const SpringEnd& endA() const { return a_; }
  const SpringEnd& endB() const { return b_; }
  const SpringSettings& settings() const { return settings_; }

  /// m, the present distance of its ends.
  btScalar length() const { return (worldPivot(a_) - worldPivot(b_)).length(); }

  /// Where an end is in the world.
  static btVector3 worldPivot(const SpringEnd& end) {
    return end.body ? end.body->getWorldTransform() * end.pivot : end.pivot;
  }

  /// N at the end of the last tick; above 0 pulls the ends together.
  double force() const { return force_; }

 private:
  friend class SoftBodySystem;

  SpringEnd a_, b_;
  SpringSettings settings_;
  double force_ = 0.0;
};

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
