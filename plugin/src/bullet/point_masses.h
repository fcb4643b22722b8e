// SPDX-License-Identifier: Zlib

// This header declares point masses, the Bullet bodies of a soft body's points, and their use in the world.

#pragma once

#include "bullet/bullet_objects.h"
#include "solver/point_state.h"

#include <btBulletDynamicsCommon.h>

#include <cstdint>
#include <memory>
#include <vector>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

struct SoftBodyData;

/// The Bullet body of one point mass: a small sphere that does not rotate. The application may delete it like
/// any other body: it has its own operator delete, and its destructor informs its owner.
class PointMass final : public OwnBody<PointMass> {
 public:
  BT_DECLARE_ALIGNED_ALLOCATOR();

  PointMass(const btRigidBodyConstructionInfo& info, SoftBodyData* owner, std::uint32_t index);
  ~PointMass() override;

  /// Returns false for two points of one body, and for a point and the body to which it is attached. This
  /// filter needs no collision group. Bullet's dispatcher may call it from several threads, so it only reads.
  bool checkCollideWithOverride(const btCollisionObject* other) const override;

  /// Point 0 also writes the soft body, for SoftBodySystem::loadBodies(). The objects get no shape in the
  /// file, so that Bullet's importer skips them.
  const char* serialize(void* data, btSerializer* serializer) const override;

  /// Enables checkCollideWithOverride(). Bullet calls it only while this flag is set, and clears the flag
  /// when the last constraint on the body is removed (btCollisionObject::setIgnoreCollisionCheck).
  void keepCollisionFilter() { m_checkCollideWith = 1; }

  void setOwner(SoftBodyData* owner) { owner_ = owner; }
  SoftBodyData* owner() const { return owner_; }
  std::uint32_t index() const { return index_; }

  btScalar massBeforePin = 0;  ///< kg

  /// The manifold of the last tick with a static or kinematic convex body, if it has a single contact. It is
  /// nullptr except between readManifolds() and gatherContacts() of a tick.
  const btPersistentManifold* cachedContact = nullptr;

 private:
  SoftBodyData* owner_;
  std::uint32_t index_;
};

// --- the points of one body --------------------------------------------------------------------------------

/// A sphere with a contact breaking threshold of a third of its radius. Bullet's own threshold, 2 % of a
/// shape's extent, is below 1 mm for a point mass: its contacts would appear and disappear repeatedly. A
/// larger threshold would merge contacts with neighbouring triangles of a mesh, which are all within the
/// threshold on such a small sphere.
struct PointSphere final : btSphereShape {
  using btSphereShape::btSphereShape;
  btScalar getContactBreakingThreshold(btScalar) const override { return getRadius() / btScalar(3); }
};

/// The Bullet bodies of the point masses of one soft body. The functions of this header make, read and write
/// them, in the world (world_points.cpp) and outside it (surface_body.cpp).
///
/// The spring step has the state in double precision, Bullet a rounded copy. The values last written to or
/// read from each body are stored. So all changes by the user are detected, to the last bit, and copied to
/// the state.
struct PointMasses {
  std::unique_ptr<PointSphere> shape;       ///< shared by all points
  std::vector<PointMass*> bodies;           ///< #points, nullptr where the application has deleted one; empty
                                            ///< until exposed
  std::vector<btVector3> leftPosition;      ///< #bodies, as last written to or read from the body
  std::vector<btVector3> leftVelocity;      ///< #bodies
  std::vector<btVector3> expectedVelocity;  ///< #bodies, after a tick without contacts; only in a world
  std::vector<unsigned char> held;          ///< #points, 1: pinned, or held by the user
  bool changed = false;  ///< the user has changed a point since the last tick; the state has the change
  bool exposed = false;  ///< the application may have changed the bodies; false: they are not read or written
  bool inFlight = false;  ///< in a tick: the bodies have the motion that Bullet solves, the state that of its
                          ///< end, to which Bullet's impulses are added; only in a world
  bool placed = false;    ///< in flight the user has placed the points: these impulses are of another place
  Points startPosition;   ///< 3 x #points, m, at the start of the tick
  std::unique_ptr<PointMass> probe;  ///< represents any of the points in queries of Bullet's narrowphase;
                                     ///< created on first use
};

/// Returns the inverse (1/kg) of a mass of the settings, rounded as in Bullet's bodies; 0 where it is not
/// finite.
double inverseOf(double mass);

/// Makes the shape and sets the inverse masses. Makes no bodies.
void initializePointMasses(SoftBodyData& body);

/// Makes the bodies with the state's positions and velocities. They are not yet in a world.
void makePointMasses(SoftBodyData& body);

/// Adds the bodies of points that were divided, if there are bodies, and shares masses and forces. The model
/// is the new one. `massBefore` (kg) are the masses of the old one.
void dividePointMasses(SoftBodyData& body, const std::vector<std::uint32_t>& pointOf,
                       const std::vector<double>& massBefore);

/// Returns the probe at the present position of point i.
PointMass& probeAt(SoftBodyData& body, std::uint32_t i);

/// Deletes the bodies that the application has not deleted. They must no longer be in a world.
void deletePointMasses(SoftBodyData& body);

/// Copies the user's changes and the inverse masses to the state, before the step. The caller sets the
/// accelerations. `allHeld`: the whole body is out of the simulation.
void gatherPoints(SoftBodyData& body, btScalar tick, bool allHeld);

/// Writes the state of points that are not held to the bodies, rounded to Bullet's precision.
void writePoints(SoftBodyData& body);

/// Writes the state of point i to its body, rounded to Bullet's precision.
void writePoint(SoftBodyData& body, std::uint32_t i);

/// Stores the present values of the Bullet body of point i, so that later changes are detected.
void remember(PointMasses& masses, std::uint32_t i);

/// Copies the user's changes since the last tick to the state.
void absorbOutsideChanges(SoftBodyData& body);

/// Returns the present position (m), with the user's changes.
Eigen::Vector3d currentPosition(const SoftBodyData& body, std::uint32_t i);

/// Returns the position (m) of point i on the straight line of its motion in the last tick, 0 at the start, 1
/// at the end. The user's changes since then shift the line. But a pin moves to a new target in the next
/// tick.
Eigen::Vector3d positionAt(const SoftBodyData& body, std::uint32_t i, double tickFraction);

/// Returns the present velocity (m/s), with the user's changes.
Eigen::Vector3d currentVelocity(const SoftBodyData& body, std::uint32_t i);

/// Returns whether the user has moved point i or changed its velocity since it was last read or written.
bool isChangedOutside(const SoftBodyData& body, std::uint32_t i);

/// Returns whether Bullet can compute with the vector: it is neither NaN nor so large that its square
/// overflows.
bool isSound(const btVector3& v);

/// Limit of isSound() in m, m/s, m/s^2 or N.
constexpr double kMaxSound = 1e18;

/// Restores a body whose motion is no longer sound to its positions at the start of the tick, at rest. Resets
/// all data that are derived from the motion.
void restoreIfUnsound(SoftBodyData& body);

/// Resets what depends on the motion so far: impulses of contacts, and estimates of the error.
void forgetMotion(SoftBodyData& body);

/// Returns whether a point has moved faster than its sleeping threshold in the last tick, or the user has
/// changed it. Compares displacements: a point at rest on an object has the velocity of a step in free fall
/// at the end of a tick.
bool anyPointMoves(const SoftBodyData& body, btScalar tick);

/// Returns the mass (kg) of a point, of a pinned one that of before; exactly that of the settings (kg) if it
/// is.
btScalar presentMass(const PointMass& point, double ofSettings);

/// Makes point i kinematic, or dynamic again with its mass.
void setPinned(SoftBodyData& body, std::uint32_t i, bool pinned);

// --- in the world ------------------------------------------------------------------------------------------

// Functions for a body with Collision::Points in the world. Each point mass is an ordinary sphere body.
// Bullet moves it and solves its contacts with dynamic bodies.

/// Makes the point masses and adds them to the world.
void addPointMasses(SoftBodyData& body);

/// Removes and deletes the point masses that the application has not deleted. Does not access a world that no
/// longer exists.
void removePointMasses(SoftBodyData& body);

/// Calls gatherPoints() and sets the accelerations from Bullet's total forces (gravity included).
void gatherWorldPoints(SoftBodyData& body, btScalar tick);

/// Writes to each body the mean velocity of the tick without the part that Bullet adds itself, after the
/// step:
///     u = (x_end - x_start) / h - a h.
/// Then Bullet's own integration x += h (u + a h) ends at the position at which the step ended.
void writeVelocitiesToBullet(SoftBodyData& body, btScalar tick);

/// Reads the bodies after Bullet's contacts. The difference D between a body's velocity and the expected one
/// is an impulse,
///     v = v_end + D,  x = x_end + h D,  D = v_bullet - v_expected.
/// A displacement that the velocity does not explain is added (split impulse, continuous collision). Then
/// runs continuous collision and writes the result to the bodies.
void finishWorldPoints(SoftBodyData& body, btScalar tick);

/// Wakes all points. `insideTick`: also applies the gravity of this step, which they missed while asleep.
void wakeWorldPoints(SoftBodyData& body, bool insideTick);

/// Sets PointMass::cachedContact from Bullet's manifolds, before a tick. Clears the impulses that
/// reportContacts() has written to the manifolds: Bullet would use them for its warm start.
void readManifolds(btDispatcher& dispatcher);

/// Excludes the contacts that this plugin solves from Bullet's solver, after gathering, until
/// restoreBreakingThresholds(). Bullet tests contacts only once per tick, at its start. On rounded shapes and
/// across adjacent edges it would brake sliding points.
void disableBulletResponse(btDispatcher& dispatcher);

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
