// SPDX-License-Identifier: Zlib
#pragma once

#include "bullet/point_mass.h"
#include "core/point_state.h"

#include <memory>
#include <vector>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

/// A sphere whose contacts are found from a third of its radius. Bullet's own threshold, 2 % of a shape's
/// extent, is under a millimetre for a point mass: its contacts would flicker. A larger one would merge the
/// contacts with neighbouring triangles of a mesh, which all lie within the threshold on so small a sphere.
struct PointSphere final : btSphereShape {
  using btSphereShape::btSphereShape;
  btScalar getContactBreakingThreshold(btScalar) const override { return getRadius() / btScalar(3); }
};

/// How the point masses of one soft body live in Bullet: each is an ordinary sphere body in the world. This
/// is the only place that creates, reads and writes them.
///
/// The spring step has the state in double; Bullet has a rounded copy. What we last left in a body is
/// remembered, so that anything the user changes between ticks is seen, to the bit, and taken over.
struct PointMasses {
  std::unique_ptr<PointSphere> shape;       ///< shared by all points
  std::vector<PointMass*> bodies;           ///< #points; nullptr where the application has deleted one
  std::vector<btVector3> leftPosition;      ///< #points, as last written to or read from the body
  std::vector<btVector3> leftVelocity;      ///< #points
  std::vector<btVector3> expectedVelocity;  ///< #points, after the tick if nothing is touched
  std::vector<unsigned char> held;          ///< #points, 1: pinned, or held by the user
  Points startPosition;                     ///< 3 x #points, m, at the start of the tick
};

/// Makes the bodies at the state's positions and velocities and adds them to the world.
void addPointMasses(SoftBodyData& body);

/// Removes and deletes those that the application has not deleted. A world that is gone is not touched.
void removePointMasses(SoftBodyData& body);

/// Called by ~PointMass when the application deletes one.
void forgetDeletedPoint(SoftBodyData& body, std::uint32_t index);

/// Before the step: takes over what changed outside, inverse masses, and the accelerations from Bullet's
/// total forces (gravity included).
void gatherPoints(SoftBodyData& body, btScalar tick);

/// After the step: gives each body the mean velocity of the tick without the part that Bullet adds itself,
///     u = (x_end - x_start) / h - a h,
/// so that Bullet's own integration x += h (u + a h) ends where the step ended.
void handOverVelocities(SoftBodyData& body, btScalar tick);

/// After Bullet's contacts: whatever it changed of the velocity it was expected to leave is an impulse,
///     v = v_end + D,  x = x_end + h D,  D = v_bullet - v_expected,
/// plus any displacement that no velocity explains (split impulse, continuous collision).
void takeBackContacts(SoftBodyData& body, btScalar tick);

/// Gives the bodies the state, rounded to Bullet's precision.
void writePoints(SoftBodyData& body);

/// Takes what the user has changed since the last tick into the state.
void absorbOutsideChanges(SoftBodyData& body);

/// Position and velocity (3-vectors, m and m/s) as they are now, including what the user has just changed.
Eigen::Vector3d currentPosition(const SoftBodyData& body, std::uint32_t i);
Eigen::Vector3d currentVelocity(const SoftBodyData& body, std::uint32_t i);

/// Whether point i has moved faster than its sleeping threshold over the last tick, or the user has changed
/// it. Its velocity at the end of a tick would not do: at rest on something it is that of a step in free
/// fall.
bool isMoving(const SoftBodyData& body, std::uint32_t i, btScalar tick);

/// Makes point i kinematic, or dynamic again with its mass.
void setPinned(SoftBodyData& body, std::uint32_t i, bool pinned);

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
