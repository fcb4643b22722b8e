// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/bullet_precision.h>

#include <btBulletDynamicsCommon.h>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

struct SoftBodyData;

/// What stands for a soft body in Bullet's world. To Bullet it is a dynamic body of the body's mass and
/// inertia, which joins islands with what is near, and which constraints hold (surface_rigid.h); but it is not
/// in the world's list of bodies to be moved, and makes no contacts in Bullet's narrowphase. Rays, sweeps and
/// contact tests do find it. Like a PointMass it may be deleted by the application.
class SurfaceObject final : public btRigidBody {
 public:
  BT_DECLARE_ALIGNED_ALLOCATOR();

  /// Without a shape, which needs the object first.
  explicit SurfaceObject(SoftBodyData* owner);
  ~SurfaceObject() override;

  /// The surface an object is, or nullptr.
  static SurfaceObject* from(btCollisionObject* object);
  static const SurfaceObject* from(const btCollisionObject* object);

  /// Bullet's dispatcher makes no contacts with it. Reads only.
  bool checkCollideWithOverride(const btCollisionObject*) const override { return false; }

  /// Bullet asks checkCollideWithOverride only while this is on, see PointMass.
  void keepCollisionFilter() { m_checkCollideWith = 1; }

  /// Whether the user has not excluded this pair (setIgnoreCollisionCheck(), from either side). `other` is no
  /// SurfaceObject.
  bool mayTouch(const btCollisionObject& other) const;

  void setOwner(SoftBodyData* owner) { owner_ = owner; }
  SoftBodyData* owner() const { return owner_; }

 private:
  SoftBodyData* owner_;
};

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
