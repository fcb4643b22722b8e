// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/bullet_precision.h>

#include <btBulletDynamicsCommon.h>

#include <cstdint>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

struct SoftBodyData;

/// The Bullet body of one point mass: a small sphere that does not spin. It may be deleted by the application
/// like any other body (it has its own operator delete and tells its owner).
class PointMass final : public btRigidBody {
 public:
  BT_DECLARE_ALIGNED_ALLOCATOR();

  PointMass(const btRigidBodyConstructionInfo& info, SoftBodyData* owner, std::uint32_t index);
  ~PointMass() override;

  /// The point mass an object is, or nullptr.
  static PointMass* from(btCollisionObject* object);
  static const PointMass* from(const btCollisionObject* object);

  /// Points of one body never collide, nor does a point with the body it is attached to. Called by Bullet's
  /// dispatcher, possibly from several threads: reads only. It costs no collision group.
  bool checkCollideWithOverride(const btCollisionObject* other) const override;

  /// Bullet asks checkCollideWithOverride only while this is on, and turns it off by itself when the last
  /// constraint on the body goes (btCollisionObject::setIgnoreCollisionCheck).
  void keepCollisionFilter() { m_checkCollideWith = 1; }

  void setOwner(SoftBodyData* owner) { owner_ = owner; }
  SoftBodyData* owner() const { return owner_; }
  std::uint32_t index() const { return index_; }

  const btRigidBody* attachedTo = nullptr;

  /// The manifold of its one contact with a static or kinematic convex body, as of the last tick; nullptr but
  /// between readManifolds() and gatherContacts() of a tick.
  const btPersistentManifold* cachedContact = nullptr;

 private:
  SoftBodyData* owner_;
  std::uint32_t index_;
};

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
