// SPDX-License-Identifier: Zlib

// Point masses are the Bullet bodies of a soft body's points. This header declares them and how they live in
// the world.

#pragma once

#include "solver/point_state.h"

#include <limber/bullet_precision.h>

#include <btBulletDynamicsCommon.h>

#include <cstdint>
#include <memory>
#include <vector>

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

  btScalar massBeforePin = 0;  ///< kg

  /// The manifold of its one contact with a static or kinematic convex body, as of the last tick; nullptr but
  /// between readManifolds() and gatherContacts() of a tick.
  const btPersistentManifold* cachedContact = nullptr;

 private:
  SoftBodyData* owner_;
  std::uint32_t index_;
};

// --- the points of one body --------------------------------------------------------------------------------

/// A sphere whose contacts are found from a third of its radius. Bullet's own threshold, 2 % of a shape's
/// extent, is under a millimetre for a point mass: its contacts would flicker. A larger one would merge the
/// contacts with neighbouring triangles of a mesh, which all lie within the threshold on so small a sphere.
struct PointSphere final : btSphereShape {
  using btSphereShape::btSphereShape;
  btScalar getContactBreakingThreshold(btScalar) const override { return getRadius() / btScalar(3); }
};

/// The Bullet bodies of the point masses of one soft body. This is the only place that creates, reads and
/// writes them; what they do in the world is in world_points.cpp, without the world in surface_body.cpp.
///
/// The spring step has the state in double; Bullet has a rounded copy. What we last left in a body is
/// remembered, so that anything the user changes between ticks is seen, to the bit, and taken over.
struct PointMasses {
  std::unique_ptr<PointSphere> shape;       ///< shared by all points
  std::vector<PointMass*> bodies;           ///< #points, nullptr where the application has deleted one; empty
                                            ///< until exposed
  std::vector<btVector3> leftPosition;      ///< #bodies, as last written to or read from the body
  std::vector<btVector3> leftVelocity;      ///< #bodies
  std::vector<btVector3> expectedVelocity;  ///< #bodies, after the tick without contacts; in a world only
  std::vector<unsigned char> held;          ///< #points, 1: pinned, or held by the user
  bool changed = false;  ///< the user has changed a point since the last tick, and the state has the change
  bool exposed = false;  ///< the application may have changed the bodies; false: they are not read or written
  Points startPosition;  ///< 3 x #points, m, at the start of the tick
  std::unique_ptr<PointMass> probe;  ///< in queries of Bullet's narrowphase it replaces any of the points;
                                     ///< created on first use
};

/// Prepares the shape and the inverse masses, without bodies.
void initializePointMasses(SoftBodyData& body);

/// Makes the bodies at the state's positions and velocities; they are in no world yet.
void makePointMasses(SoftBodyData& body);

/// Returns the probe at the present position of point i.
PointMass& probeAt(SoftBodyData& body, std::uint32_t i);

/// Deletes those that the application has not deleted; they are in no world any more.
void deletePointMasses(SoftBodyData& body);

/// Before the step: takes over what changed outside, and inverse masses; accelerations are left to the
/// caller. `allHeld`: the body as a whole is out of the simulation.
void gatherPoints(SoftBodyData& body, btScalar tick, bool allHeld);

/// Gives the bodies the state, rounded to Bullet's precision.
void writePoints(SoftBodyData& body);

/// As writePoints() for one point.
void writePoint(SoftBodyData& body, std::uint32_t i);

/// Takes what the user has changed since the last tick into the state.
void absorbOutsideChanges(SoftBodyData& body);

/// Position and velocity (3-vectors, m and m/s) as they are now, including what the user has just changed.
Eigen::Vector3d currentPosition(const SoftBodyData& body, std::uint32_t i);

/// On the straight way that point i went in the last tick, 0 at its start, 1 at its end, moved along by what
/// the user has changed since. A pin that has been given a new target is on its way there in the next tick.
Eigen::Vector3d positionAt(const SoftBodyData& body, std::uint32_t i, double tickFraction);
Eigen::Vector3d currentVelocity(const SoftBodyData& body, std::uint32_t i);

/// Whether the user has moved point i, or changed its velocity, since it was last read or written.
bool isChangedOutside(const SoftBodyData& body, std::uint32_t i);

/// Whether Bullet can reckon with it: neither NaN nor so large that its square overflows.
bool isSound(const btVector3& v);

/// m, m/s, m/s^2, N: limit of isSound().
constexpr double kMaxSound = 1e18;

/// Puts a body whose motion is not sound any more back to where it was at the start of the tick, at rest.
/// Whatever is derived from the motion starts anew.
void restoreIfUnsound(SoftBodyData& body);

/// Whether a point has moved faster than its sleeping threshold over the last tick, or the user has changed
/// it. Its velocity at the end of a tick would not do: at rest on something it is that of a step in free
/// fall.
bool anyPointMoves(const SoftBodyData& body, btScalar tick);

/// Makes point i kinematic, or dynamic again with its mass.
void setPinned(SoftBodyData& body, std::uint32_t i, bool pinned);

// --- in the world ------------------------------------------------------------------------------------------

// How a body with Collision::Points lives in the world: each point mass is an ordinary sphere body, which
// Bullet moves and whose contacts with dynamic bodies Bullet solves.

/// Makes the point masses and adds them to the world.
void addPointMasses(SoftBodyData& body);

/// Removes and deletes those that the application has not deleted. A world that is gone is not touched.
void removePointMasses(SoftBodyData& body);

/// gatherPoints(), and the accelerations from Bullet's total forces (gravity included).
void gatherWorldPoints(SoftBodyData& body, btScalar tick);

/// After the step: gives each body the mean velocity of the tick without the part that Bullet adds itself,
///     u = (x_end - x_start) / h - a h,
/// so that Bullet's own integration x += h (u + a h) ends where the step ended.
void writeVelocitiesToBullet(SoftBodyData& body, btScalar tick);

/// After Bullet's contacts: whatever it changed of the velocity it was expected to leave is an impulse,
///     v = v_end + D,  x = x_end + h D,  D = v_bullet - v_expected,
/// plus any displacement that no velocity explains (split impulse, continuous collision).
/// Then continuous collision, and the result is written to the bodies.
void finishWorldPoints(SoftBodyData& body, btScalar tick);

/// Wakes all points; they get the gravity of this step that they missed while asleep.
void wakeWorldPoints(SoftBodyData& body, bool insideTick);

/// Before a tick: gives every point mass its contact in Bullet's manifolds, and takes out of these what an
/// earlier tick reported (below), before Bullet starts from it.
void readManifolds(btDispatcher& dispatcher);

/// After gathering: Bullet's solver leaves contacts that have rows alone, until reportContactImpulses(). It
/// would see them once a tick, at its start: where shapes are rounded, or meet edges beside each other, it
/// brakes what slides past these.
void disableBulletResponse(btDispatcher& dispatcher);

/// After the tick: what the rows have borne is written to Bullet's manifolds, where users read contact forces
/// (btManifoldPoint::m_appliedImpulse).
void reportContactImpulses(btDispatcher& dispatcher);

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
