// SPDX-License-Identifier: Zlib

// This header computes how far a point may move in a tick and what it may touch, and declares the search for
// its contacts.

#pragma once

#include "bullet/soft_body_data.h"

#include <BulletCollision/CollisionShapes/btBoxShape.h>
#include <BulletCollision/CollisionShapes/btCompoundShape.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <vector>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

struct TickContacts;
struct LinkedGroup;

// --- search region of a point ------------------------------------------------------------------------------

/// Safety factor: a point can become faster within the tick than it was at its start.
constexpr double kSearchPerMotion = 1.5;

/// Cosine of an angle. Of two contacts of a point with a smaller angle between their normals, only the nearer
/// one counts: neighbouring triangles of a flat surface are one surface.
constexpr double kSameSurface = 0.995;

/// Returns the largest speed (m/s) at which objects that overlap by about `size` (m) are separated, so that
/// they are not thrown apart. A fall through 0.65 of the size gives this speed, 0.5 m/s for points of 2 cm.
/// Without gravity it is a tenth of the size per tick.
inline double recoverySpeed(double size, double gravity, double tick) {
  return std::max(std::sqrt(1.3 * gravity * size), 0.1 * size / tick);
}

/// The region that a point may enter in a tick.
struct SearchRegion {
  Eigen::AlignedBox3d box;  ///< m
  double distance;          ///< m, beyond the radius
};

/// Returns the region of point i up to a distance (m) beyond its radius.
inline SearchRegion searchRegionAround(const SoftBodyData& body, Eigen::Index i, double distance) {
  const Eigen::Vector3d x = body.state.position.col(i);
  const double size = radiusOf(body) + distance;
  return {{x.array() - size, x.array() + size}, distance};
}

/// Returns the region of a point with a velocity in `time` s. `partnerMotion` (m) is the motion of the
/// partner towards it.
inline SearchRegion searchRegionFrom(const SoftBodyData& body, Eigen::Index i,
                                     const Eigen::Vector3d& velocity, double time,
                                     double partnerMotion = 0.0) {
  const double motion = time * velocity.norm() + time * time * body.state.acceleration.col(i).norm();
  return searchRegionAround(body, i, kSearchPerMotion * motion + partnerMotion + radiusOf(body) / 3.0);
}

inline SearchRegion searchRegionOf(const SoftBodyData& body, Eigen::Index i, double tick,
                                   double partnerMotion = 0.0) {
  return searchRegionFrom(body, i, body.state.velocity.col(i), tick, partnerMotion);
}

/// Returns whether the region overlaps the broadphase box of an object.
inline bool overlaps(const SearchRegion& searchRegion, const btCollisionObject& partner) {
  const btBroadphaseProxy& proxy = *partner.getBroadphaseHandle();
  return searchRegion.box.intersects({toEigen(proxy.m_aabbMin), toEigen(proxy.m_aabbMax)});
}

/// Returns bounds of a body's points in a tick without contacts: the body moves with its mean velocity, and
/// each point moves relative to it as in searchRegionOf(). They are smaller than the box around all search
/// regions, because those allow for points that a hit pushes aside. `fall`: m, the largest motion by
/// accelerations.
inline SweptBounds sweptBoundsOf(SoftBodyData& body, double tick, double fall) {
  const MotionSums& s = sumsOf(body);
  const double radius = radiusOf(body);
  const double margin = radius + radius / 3.0 + kSearchPerMotion * (tick * std::sqrt(s.fastest) + fall);
  const Eigen::Vector3d displacement =
      kSearchPerMotion * tick * Eigen::Map<const Eigen::Vector3d>(s.meanVelocity);
  const Eigen::Vector3d low = Eigen::Map<const Eigen::Vector3d>(s.low) + displacement.cwiseMin(0.0),
                        high = Eigen::Map<const Eigen::Vector3d>(s.high) + displacement.cwiseMax(0.0);
  return {{low.array() - margin, high.array() + margin},
          margin - radius + displacement.norm(),
          tick,
          displacement};
}

inline SweptBounds sweptBoundsOf(SoftBodyData& body, double tick) {
  const double squared = body.state.acceleration.colwise().squaredNorm().maxCoeff();
  return sweptBoundsOf(body, tick, tick * tick * std::sqrt(squared));
}

/// Returns bounds (m) of another body with a surface in the present tick. They depend on its state alone, not
/// on the box that the broadphase has of it. May be called while other threads read the body.
inline Eigen::AlignedBox3d presentBoundsOf(const SoftBodyData& other) {
  if (!other.asleep) return other.surface.presentBounds.box;
  return boxAround(other.state.position, radiusOf(other) + radiusOf(other) / 3.0);
}

/// Returns the box (m) of an object's shape at its present pose.
inline Eigen::AlignedBox3d boxOf(const btCollisionObject& object) {
  btVector3 low, high;
  object.getCollisionShape()->getAabb(object.getWorldTransform(), low, high);
  return {toEigen(low), toEigen(high)};
}

/// Returns the share, from -1 to 1, of an object's rotation across a normal that its partner's surroundings
/// have. `spin`, `own`: rad/s, of the object and of the partner.
double turningShare(const Eigen::Vector3d& own, const Eigen::Vector3d& spin, const Eigen::Vector3d& normal);

/// Returns the bounds (m) of a rigid body in a tick if nothing stops it.
Eigen::AlignedBox3d boundsOf(const btRigidBody& rigid, double tick);

// --- filters -----------------------------------------------------------------------------------------------

/// Returns whether any of the body's points, or its surface, may collide with the object. The body's own
/// points and surface never do.
inline bool canHit(const SoftBodyData& body, const btCollisionObject& object) {
  const PointMass* point = PointMass::from(&object);
  const SurfaceObject* surface = body.surface.object;
  if ((point && point->owner() == &body) || &object == surface || !object.hasContactResponse()) return false;
  if (surface) return surface->mayTouch(object) && arePaired(*body.world, *surface, object);
  const auto& points = body.masses.bodies;
  return std::any_of(points.begin(), points.end(),
                     [&](const PointMass* p) { return p && arePaired(*body.world, *p, object); });
}

/// Returns whether point i may collide with an object that passed canHit() of its body.
inline bool canHit(const SoftBodyData& body, std::uint32_t i, const btCollisionObject& object) {
  if (body.masses.bodies.empty()) return !isAttached(body, i, object);
  const PointMass& point = *body.masses.bodies[i];
  return (body.surface.object || arePaired(*body.world, point, object)) && point.checkCollideWith(&object) &&
         object.checkCollideWith(&point);
}

// --- contacts with static and kinematic objects ------------------------------------------------------------

/// Fills body.contacts with a contact for every static or kinematic surface that a point may touch in the
/// coming tick. Bullet's broadphase finds the partners. Static ones are split into pieces (held_pieces.cpp):
/// a point gets plane contacts where all pieces near it are flat, else contacts that follow the surface
/// within the tick. On kinematic objects that move, Bullet's narrowphase finds planes; slow points keep that
/// of the last tick (PointMass::cachedContact). gatherPairs() handles dynamic objects. Call after
/// gatherPoints().
void gatherContacts(SoftBodyData& body, btScalar tick);

/// Creates body.watch. It finds contacts of points that move farther within a tick than gatherContacts() has
/// searched, thrown by springs or neighbours. It is on while an object is near.
void addContactWatch(SoftBodyData& body);

/// Returns whether, after a step without the watch, a point that left its search region may have missed a
/// contact. Then the body must be stepped again, with the watch.
bool mayHaveMissedContacts(SoftBodyData& body);

/// Finds the partners at rest, solids of one convex shape, in which a closed body is that has been placed
/// there: HeldPartner::out. Their points inside then get contacts along that direction only, since nearest
/// faces would push different points to different sides.
void findWaysOut(SoftBodyData& body);

/// Whether the body has been placed into a solid in which the point is, or which is on the point's way out:
/// in the body, or through one of the point's edges.
bool isPushedOut(const SoftBodyData& body, const HeldPartner& held, std::uint32_t i);

/// A search for the contacts of a point that moves in the tick.
struct PointSearch {
  Eigen::Vector3d velocity;  ///< m/s, at its start
  double time;               ///< s, until the end of the tick
  double minTime;            ///< s, until the point may be searched again
  bool replacesPlanes;       ///< the next search replaces all planes that this one finds
};

/// Adds contacts of one point with the static partners of its body. Returns the distance (m) up to which the
/// contacts are known: that of the point's motion in search.time or, where there are many small pieces, less,
/// down to that in search.minTime. The watch searches for the rest.
double addStaticRows(SoftBodyData& body, std::uint32_t i, const PointSearch& search, btScalar tick);

/// Adds contacts with a kinematic one of body.heldPartners for a point that starts with a velocity and moves
/// for `time` s of the tick.
void addRows(SoftBodyData& body, std::uint32_t i, std::uint32_t partner, const Eigen::Vector3d& velocity,
             double time, btScalar tick);

// --- contacts with dynamic objects -------------------------------------------------------------------------

/// Adds to `found` a contact for every surface of a dynamic rigid body that a point of the body may touch in
/// the coming tick. Bullet's narrowphase finds it. Wakes a sleeping partner.
void gatherPairs(SoftBodyData& body, btRigidBody& partner, btScalar tick, TickContacts& found);

/// Adds a contact for every two point masses in the world, of different bodies, that may touch in the coming
/// tick. Call it after all awake groups have been gathered, if there is more than one body.
void gatherPointPairs(const std::vector<LinkedGroup*>& awake, btScalar tick, TickContacts& found);

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
