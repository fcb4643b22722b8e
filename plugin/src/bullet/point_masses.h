// SPDX-License-Identifier: Zlib
#pragma once

#include "bullet/point_mass.h"
#include "solver/point_state.h"

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

/// The Bullet bodies of the point masses of one soft body. This is the only place that creates, reads and
/// writes them; what they do in the world is in world_points.h, without the world in surface_body.h.
///
/// The spring step has the state in double; Bullet has a rounded copy. What we last left in a body is
/// remembered, so that anything the user changes between ticks is seen, to the bit, and taken over.
struct PointMasses {
  std::unique_ptr<PointSphere> shape;   ///< shared by all points
  std::vector<PointMass*> bodies;       ///< #points; nullptr where the application has deleted one
  std::vector<btVector3> leftPosition;  ///< #points, as last written to or read from the body
  std::vector<btVector3> leftVelocity;  ///< #points
  std::vector<btVector3>
      expectedVelocity;             ///< #points, after the tick if nothing is touched; in a world only
  std::vector<unsigned char> held;  ///< #points, 1: pinned, or held by the user
  bool changed = false;  ///< the user has changed a point since the last tick, and the state knows already
  bool shared = true;    ///< false: nobody outside has seen the bodies yet; they are neither read nor written
  Points startPosition;  ///< 3 x #points, m, at the start of the tick
};

/// Makes the bodies at the state's positions and velocities; they are in no world yet.
void makePointMasses(SoftBodyData& body);

/// Deletes those that the application has not deleted; they are in no world any more.
void deletePointMasses(SoftBodyData& body);

/// Called by ~PointMass when the application deletes one.
void forgetDeletedPoint(SoftBodyData& body, std::uint32_t index);

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

/// Puts a body whose motion is not sound any more back to where it was at the start of the tick, at rest.
/// Whatever is derived from the motion starts anew.
void restoreIfUnsound(SoftBodyData& body);

/// Whether a point has moved faster than its sleeping threshold over the last tick, or the user has changed
/// it. Its velocity at the end of a tick would not do: at rest on something it is that of a step in free
/// fall.
bool anyPointMoves(const SoftBodyData& body, btScalar tick);

/// Makes point i kinematic, or dynamic again with its mass.
void setPinned(SoftBodyData& body, std::uint32_t i, bool pinned);

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
