// SPDX-License-Identifier: Zlib

// In surface mode one object stands in Bullet's world for the whole of a soft body, and its user moves it as
// a rigid body.

#pragma once

#include "solver/point_state.h"

#include <limber/bullet_precision.h>
#include <limber/spring_network.h>

#include <btBulletDynamicsCommon.h>

#include <array>
#include <cstdint>
#include <vector>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

// --- what Bullet has ---------------------------------------------------------------------------------------

struct SoftBodyData;

/// What stands for a soft body in Bullet's world. To Bullet it is a dynamic body of the body's mass and
/// inertia, which joins islands with what is near, and which constraints hold (surface_rigid.cpp); but it is
/// not in the world's list of bodies to be moved, and makes no contacts in Bullet's narrowphase. Rays, sweeps
/// and contact tests do find it. Like a PointMass it may be deleted by the application.
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

/// The surface of a soft body as it is now, for Bullet's queries: its triangles, or, without any, two crossed
/// strips along each structural spring, as wide as its points.
///
/// Triangle t of Bullet is triangle t of the surface; or strip triangle t % 4 of spring springs()[t / 4].
class SurfaceShape final : public btConcaveShape {
 public:
  BT_DECLARE_ALIGNED_ALLOCATOR();

  /// `positions` (3 x #points, m) must outlive it. `radius` in metres. `mirrored`: the body's triangles are
  /// its network's turned over.
  SurfaceShape(const SpringNetwork& network, bool mirrored, const Points& positions, btScalar radius);

  /// The box (world coordinates, m) that the broadphase gets.
  void setBox(const btVector3& low, const btVector3& high) { low_ = low, high_ = high; }
  const btVector3& low() const { return low_; }
  const btVector3& high() const { return high_; }

  /// Where the owner is when the points are where `positions` says: once it has been moved, the points will
  /// be.
  void setPose(const btTransform& pose) { pose_ = pose; }

  const std::vector<std::uint32_t>& springs() const { return springs_; }

  void getAabb(const btTransform& t, btVector3& aabbMin, btVector3& aabbMax) const override;
  void processAllTriangles(btTriangleCallback* callback, const btVector3& aabbMin,
                           const btVector3& aabbMax) const override;

  void setLocalScaling(const btVector3&) override {}  ///< a soft body has its scale in its settings
  const btVector3& getLocalScaling() const override { return scaling_; }
  void calculateLocalInertia(btScalar, btVector3& inertia) const override { inertia.setZero(); }
  const char* getName() const override { return "SoftSurface"; }

 private:
  struct Query;
  btVector3 local(std::uint32_t point) const;
  void reportStrips(const Query& query) const;

  const SpringNetwork* network_;
  bool mirrored_;
  const Points* positions_;
  std::vector<std::uint32_t> springs_;  ///< those that are shown as strips
  btVector3 low_ = btVector3(0, 0, 0), high_ = btVector3(0, 0, 0);
  btTransform pose_ = btTransform::getIdentity();
  btVector3 scaling_ = btVector3(1, 1, 1);
};

// --- in the world ------------------------------------------------------------------------------------------

// How a body with Collision::Surface lives in the world: one object stands for it, the point masses are
// outside, and nothing is handed to Bullet's solver or taken back from it.

/// Makes the point masses and the object, and adds the object to the world.
void addSurface(SoftBodyData& body);

/// Deletes what the application has not deleted. A world that is gone is not touched.
void removeSurface(SoftBodyData& body);

/// From now on the point masses are kept up to date and read: the application has one.
void exposePoints(SoftBodyData& body);

/// Moves the forces that the user has applied to the points since the last call into surface.force.
void collectForces(SoftBodyData& body);

/// gatherPoints(), and the accelerations from gravity and forces.
void gatherSurface(SoftBodyData& body, btScalar tick);

/// At the start of a tick: where a body that has been thrown since the last one may get is told to Bullet's
/// broadphase, in which others look for it.
void updateBroadphaseBox(SoftBodyData& body, btScalar tick);

/// After the step: gives the broadphase the box of this tick's motion and of what the points may reach in the
/// next.
void writeBoxToBullet(SoftBodyData& body, btScalar tick);

/// After the tick: Bullet's linear damping of the points, continuous collision, and the result written to the
/// point masses and the object.
void finishSurface(SoftBodyData& body, btScalar tick);

/// As anyPointMoves().
bool anySurfacePointMoves(const SoftBodyData& body, btScalar tick);

/// Whether the user has changed a point of a sleeping body.
bool isSurfaceChanged(const SoftBodyData& body);

/// Wakes the object, and the point masses if they are shared.
void wakeSurface(SoftBodyData& body);

// --- to its user a rigid body ------------------------------------------------------------------------------

// To its user the surface object is a rigid body with the mass, inertia and mean motion of the body's points
// that are not held. Whatever differs from what was last left in it is the user's doing, or that of a
// constraint in Bullet's solver, and moves all points as it would move a rigid body.

/// Leaves in the object where and how the body is now. Its basis turns with the body.
void writeObject(SoftBodyData& body);

/// Whether the user has moved the object or changed its velocity.
bool isObjectChanged(const SoftBodyData& body);

/// Gives the points what differs in the object. `drift` (s): for so long they have moved with the change of
/// velocity.
void readObject(SoftBodyData& body, double drift = 0.0);

/// At the start of a tick: adds the forces on the object, which act in all ticks of a stepSimulation(), to
/// the points' accelerations. What acts on one that sleeps is lost, as with Bullet's bodies.
void accelerateByObject(SoftBodyData& body);
void dropObjectForces(SoftBodyData& body);

/// Marks the bodies that Bullet's constraints hold by their objects (SurfaceData::joined).
void markJoined(const std::vector<SoftBodyData*>& bodies, btDiscreteDynamicsWorld& world);

/// Before Bullet's solver: an object in a constraint has the mean velocity of the tick.
void writeObjectToBullet(SoftBodyData& body, double tick);

/// After it: what the constraint gave has acted from the start of the tick on. It pushes no point into what
/// its contacts keep it out of.
void readObjectFromBullet(SoftBodyData& body, double tick);

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
