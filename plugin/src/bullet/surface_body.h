// SPDX-License-Identifier: Zlib

// In surface mode one object represents the whole soft body in Bullet's world. Users move it like a rigid
// body.

#pragma once

#include "bullet/bullet_objects.h"
#include "solver/point_state.h"

#include <limber/bullet_precision.h>
#include <limber/spring_network.h>

#include <btBulletDynamicsCommon.h>

#include <Eigen/Geometry>

#include <array>
#include <cstdint>
#include <vector>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

// --- Bullet's objects --------------------------------------------------------------------------------------

struct SoftBodyData;

/// The object that represents a soft body in Bullet's world. For Bullet it is a dynamic body with the mass
/// and inertia of the soft body. It joins islands with near objects, and constraints act on it
/// (surface_rigid.cpp). But the world does not move it, and it has no contacts in Bullet's narrowphase. Rays,
/// sweeps and contact tests find it. The application may delete it, like a PointMass.
class SurfaceObject final : public OwnBody<SurfaceObject> {
 public:
  BT_DECLARE_ALIGNED_ALLOCATOR();

  /// Makes the object without a shape. The shape is made after the object.
  explicit SurfaceObject(SoftBodyData* owner);
  ~SurfaceObject() override;

  /// Returns false, so that Bullet's dispatcher makes no contacts with the object. Only reads.
  bool checkCollideWithOverride(const btCollisionObject*) const override { return false; }

  /// Also writes the soft body, for SoftBodySystem::loadBodies(). Bullet's importer skips the object itself,
  /// because it does not know the type of its shape.
  const char* serialize(void* data, btSerializer* serializer) const override;

  /// Of the broadphase proxy with which addSurface() or adoptObject() added the object to the world.
  int proxyId = 0;

  /// Enables checkCollideWithOverride(), see PointMass::keepCollisionFilter().
  void keepCollisionFilter() { m_checkCollideWith = 1; }

  /// Returns false if the user has excluded this pair (setIgnoreCollisionCheck() of either object). `other`
  /// must not be a SurfaceObject.
  bool mayTouch(const btCollisionObject& other) const;

  void setOwner(SoftBodyData* owner) { owner_ = owner; }
  SoftBodyData* owner() const { return owner_; }

 private:
  SoftBodyData* owner_;
};

/// The present surface of a soft body, for Bullet's queries: its triangles. A body without triangles has two
/// crossed strips along each structural spring, as wide as its points.
///
/// Triangle t of Bullet is triangle t of the surface, or strip triangle t % 4 of spring springs()[t / 4].
class SurfaceShape final : public btConcaveShape {
 public:
  BT_DECLARE_ALIGNED_ALLOCATOR();

  /// `positions` (3 x #points, m) must outlive the shape. `radius` is in metres. `mirrored`: the body's
  /// triangles have the opposite orientation of the network's.
  SurfaceShape(const SpringNetwork& network, bool mirrored, const Points& positions, btScalar radius);

  /// Sets the box for the broadphase (world coordinates, m).
  void setBox(const btVector3& low, const btVector3& high) { low_ = low, high_ = high; }
  const btVector3& low() const { return low_; }
  const btVector3& high() const { return high_; }

  /// Sets the network of a body that has torn.
  void setNetwork(const SpringNetwork& network);

  /// Sets the object's pose for which the points are at `positions`. When the user has moved the object,
  /// queries already see the surface at its new pose, and the points are moved later.
  void setPose(const btTransform& pose) { pose_ = pose; }

  const std::vector<std::uint32_t>& springs() const { return springs_; }

  void getAabb(const btTransform& t, btVector3& aabbMin, btVector3& aabbMax) const override;
  void processAllTriangles(btTriangleCallback* callback, const btVector3& aabbMin,
                           const btVector3& aabbMax) const override;

  void setLocalScaling(const btVector3&) override {}  ///< the scale of a soft body is in its settings
  const btVector3& getLocalScaling() const override { return scaling_; }
  void calculateLocalInertia(btScalar, btVector3& inertia) const override { inertia.setZero(); }
  const char* getName() const override { return "SoftSurface"; }

 private:
  struct Query;
  btVector3 local(std::uint32_t point) const;
  void reportStrips(const Query& query) const;

  const SpringNetwork* network_ = nullptr;
  bool mirrored_;
  const Points* positions_;
  std::vector<std::uint32_t> springs_;  ///< the springs that are reported as strips
  btVector3 low_ = btVector3(0, 0, 0), high_ = btVector3(0, 0, 0);
  btTransform pose_ = btTransform::getIdentity();
  btVector3 scaling_ = btVector3(1, 1, 1);
};

// --- in the world ------------------------------------------------------------------------------------------

// Functions for a body with Collision::Surface in the world. One object represents the body. The point masses
// are outside the world, and Bullet's solver neither reads nor changes them.

/// Prepares the point masses, makes the object and adds it to the world.
void addSurface(SoftBodyData& body);

/// Takes over an object that the user has added to the world again, maybe as a rigid body, which Bullet
/// moves.
void adoptObject(SoftBodyData& body);

/// Deletes the objects that the application has not deleted. Does not access a world that no longer exists.
void removeSurface(SoftBodyData& body);

/// Makes the body's system distinguish one stepSimulation() from the next. Any thread may call it within a
/// tick.
void watchSteps(SoftBodyData& body);

/// Makes the point masses. From now on they are read and written in each tick, because the application has
/// access to one.
void exposePoints(SoftBodyData& body);

/// Adds the forces that the user has applied to the points since the last call to `surface.force`, and clears
/// them.
void collectForces(SoftBodyData& body);

/// Adds a force (N) on point i, which acts in all ticks of the coming stepSimulation().
void addForce(SoftBodyData& body, std::uint32_t i, const Eigen::Vector3d& force);

/// Adds the forces of addForce() to `surface.force`.
void takeForces(SoftBodyData& body);

/// Discards the results of searches for contacts.
void forgetSearches(SoftBodyData& body);

/// Reads the object and the exposed points, and sets the accelerations from gravity and forces.
void gatherSurface(SoftBodyData& body, btScalar tick);

/// Updates the box in Bullet's broadphase at the start of a tick, if the body may leave it: the user may have
/// changed the body's velocity since the last tick. Other bodies search for it in the broadphase. Returns
/// whether the box has changed. Also sets surface.presentBounds.
bool updateBroadphaseBox(SoftBodyData& body, btScalar tick);

/// Sets the box in Bullet's broadphase to the present points, between ticks.
void updateQueryBox(SoftBodyData& body);

/// Sets the box for the broadphase after the step: it contains the motion of this tick and all positions that
/// the points may have in the next one.
void writeBoxToBullet(SoftBodyData& body, btScalar tick);

/// Applies Bullet's linear damping to the points, reads the object, and writes the result to the point masses
/// and the object, after the tick.
void finishSurface(SoftBodyData& body, btScalar tick);

/// Returns whether a point moves too fast for sleep, see anyPointMoves().
bool anySurfacePointMoves(SoftBodyData& body, btScalar tick);

/// Returns whether the user has changed the object or a point of a sleeping body.
bool isSurfaceChanged(const SoftBodyData& body);

/// Wakes the object, and the point masses if they are exposed.
void wakeSurface(SoftBodyData& body);

// --- the object as a rigid body ----------------------------------------------------------------------------

// For its user the surface object is a rigid body with the mass, inertia and mean motion of the points that
// are not held. A difference from the values last written to it comes from the user or from a constraint in
// Bullet's solver. It moves all points as it would move a rigid body.

/// The rigid body with the mass, inertia, momentum and angular momentum of the points that are not held.
struct RigidFit {
  double mass = 0.0;                                         ///< kg
  Eigen::Vector3d center = Eigen::Vector3d::Zero();          ///< m
  Eigen::Matrix3d inverseInertia = Eigen::Matrix3d::Zero();  ///< 1/(kg m^2), about world axes
  Eigen::Matrix3d factor = Eigen::Matrix3d::Zero();          ///< F with inverseInertia = F F^T
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();        ///< m/s
  Eigen::Vector3d spin = Eigen::Vector3d::Zero();            ///< rad/s
};

/// Fits a rigid body to the present positions and velocities.
RigidFit fitRigid(SoftBodyData& body);

/// Rotates SurfaceData::frame with the body and returns it.
const Eigen::Quaterniond& followRotation(SoftBodyData& body);

/// Turns the points about `from` (m), which goes to `to`. Velocity and angular velocity of the body as a
/// whole do not change. `withPins`: pinned points move, too.
void moveRigidly(SoftBodyData& body, const Eigen::Quaterniond& turn, const Eigen::Vector3d& from,
                 const Eigen::Vector3d& to, bool withPins);

/// Writes the body's present pose and motion to the object. The object's basis rotates with the body.
void writeObject(SoftBodyData& body);

/// Returns whether the user has moved the object or changed its velocity.
bool isObjectChanged(const SoftBodyData& body);

/// Applies the changes of the object to the points. With a `tick` (s), the changes of velocity have acted
/// since its start, and the points move accordingly.
void readObject(SoftBodyData& body, double tick = 0.0);

/// Takes the forces on the object, which Bullet does not clear at the end of a stepSimulation().
void takeObjectForces(SoftBodyData& body);

/// Adds the forces on the object, which act in all ticks of a stepSimulation(), to the points' accelerations,
/// at the start of a tick.
void accelerateByObject(SoftBodyData& body);

/// Discards the forces on the object of a sleeping body: they are lost, as for Bullet's bodies.
void dropObjectForces(SoftBodyData& body);

/// Gives the object these velocities (m/s, rad/s) for Bullet's solver. readObject() applies what that
/// changes.
void offerMotion(SoftBodyData& body, const Eigen::Vector3d& velocity, const Eigen::Vector3d& spin);

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
