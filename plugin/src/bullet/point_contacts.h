// SPDX-License-Identifier: Zlib

// This header tells how far a point may get in a tick and what it may touch, and declares what finds its
// contacts.

#pragma once

#include "bullet/bullet_objects.h"
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

// --- what a point may reach --------------------------------------------------------------------------------

/// A point can be pushed faster within the tick than it was at its start.
constexpr double kSearchPerMotion = 1.5;

/// Of two contacts of a point whose normals are closer than this (cosine), only the nearer counts:
/// neighbouring triangles of a flat surface are one surface.
constexpr double kSameSurface = 0.995;

/// m/s at which things that have got `size` (m) large into each other are drawn apart at most: they must not
/// fly. A fall through 0.65 of the size is as fast, 0.5 m/s for points of 2 cm. Without gravity it is a tenth
/// of the size in a tick.
inline double recoverySpeed(double size, double gravity, double tick) {
  return std::max(std::sqrt(1.3 * gravity * size), 0.1 * size / tick);
}

/// Where a point may get in a tick.
struct SearchRegion {
  Eigen::Vector3d low, high;
  double distance;  ///< m, beyond the radius
};

/// Of a point with a velocity in `time` s; `partnerMotion` (m) is what comes towards it.
inline SearchRegion searchRegionFrom(const SoftBodyData& body, Eigen::Index i,
                                     const Eigen::Vector3d& velocity, double time,
                                     double partnerMotion = 0.0) {
  const double radius = double(body.masses.shape->getRadius());
  const Eigen::Vector3d x = body.state.position.col(i);
  const double motion = time * velocity.norm() + time * time * body.state.acceleration.col(i).norm();
  const double distance = kSearchPerMotion * motion + partnerMotion + radius / 3.0;
  const double size = radius + distance;
  return {x.array() - size, x.array() + size, distance};
}

inline SearchRegion searchRegionOf(const SoftBodyData& body, Eigen::Index i, double tick,
                                   double partnerMotion = 0.0) {
  return searchRegionFrom(body, i, body.state.velocity.col(i), tick, partnerMotion);
}

/// Whether the box of what is reached meets that of an object in the broadphase.
inline bool overlaps(const SearchRegion& searchRegion, const btCollisionObject& partner) {
  const btBroadphaseProxy& proxy = *partner.getBroadphaseHandle();
  return (toEigen(proxy.m_aabbMin).array() <= searchRegion.high.array()).all() &&
         (toEigen(proxy.m_aabbMax).array() >= searchRegion.low.array()).all();
}

/// The mean of a quantity per point, by mass.
inline Eigen::Vector3d meanOf(const SpringNetwork& network, const Points& quantity) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (Eigen::Index i = 0; i < quantity.cols(); ++i)
    mean += network.massFractions[static_cast<std::size_t>(i)] * quantity.col(i);
  return mean;
}

/// Where the points of a body may get in a tick if nothing is in their way: the body flies on, and its points
/// move relative to that as each may (searchRegionOf). Smaller than the box around all reaches, which also
/// hold what a hit may push aside.
inline SweptBounds sweptBoundsOf(const SoftBodyData& body, double tick) {
  const PointState& s = body.state;
  const Eigen::Vector3d mean = meanOf(*body.network, s.velocity);
  Eigen::AlignedBox3d box;
  double fastest = 0.0;
  for (Eigen::Index i = 0; i < s.position.cols(); ++i) {
    box.extend(s.position.col(i));
    fastest = std::max(fastest, (s.velocity.col(i) - mean).squaredNorm());
  }
  const double radius = double(body.masses.shape->getRadius());
  const double fall = tick * tick * s.acceleration.col(0).norm();
  const double margin = radius + radius / 3.0 + kSearchPerMotion * (tick * std::sqrt(fastest) + fall);
  const Eigen::Vector3d displacement = kSearchPerMotion * tick * mean;
  const Eigen::Vector3d low = box.min() + displacement.cwiseMin(0.0),
                        high = box.max() + displacement.cwiseMax(0.0);
  return {{low.array() - margin, high.array() + margin},
          margin - radius + displacement.norm(),
          tick,
          displacement};
}

// --- what it may touch -------------------------------------------------------------------------------------

/// Whether contacts of `own`, the surface object or a point in the world, with another object count: both
/// answer them, and Bullet's broadphase pairs the two, by groups and masks or as the user's
/// btOverlapFilterCallback says.
inline bool arePaired(const SoftBodyData& body, const btCollisionObject& own,
                      const btCollisionObject& other) {
  auto* first = const_cast<btBroadphaseProxy*>(own.getBroadphaseHandle());
  auto* second = const_cast<btBroadphaseProxy*>(other.getBroadphaseHandle());
  return first && second && own.hasContactResponse() && other.hasContactResponse() &&
         body.world->getPairCache()->needsBroadphaseCollision(first, second);
}

/// Whether any of the body's points, or its surface, may collide with what has this proxy. The body's own
/// points and surface never do.
inline bool canHit(const SoftBodyData& body, const btBroadphaseProxy& proxy) {
  const auto& object = *static_cast<const btCollisionObject*>(proxy.m_clientObject);
  const PointMass* point = PointMass::from(&object);
  const SurfaceObject* surface = body.surface.object;
  if ((point && point->owner() == &body) || &object == surface || !object.hasContactResponse()) return false;
  if (surface)
    return (SurfaceObject::from(&object) || surface->mayTouch(object)) && arePaired(body, *surface, object);
  const auto& points = body.masses.bodies;
  return std::any_of(points.begin(), points.end(),
                     [&](const PointMass* p) { return p && arePaired(body, *p, object); });
}

/// Whether point i may collide with an object that canHit() of its body has let pass.
inline bool canHit(const SoftBodyData& body, std::uint32_t i, const btCollisionObject& object) {
  if (body.masses.bodies.empty()) return !isAttached(body, i, object);
  const PointMass& point = *body.masses.bodies[i];
  return (body.surface.object || arePaired(body, point, object)) && point.checkCollideWith(&object) &&
         object.checkCollideWith(&point);
}

// --- contacts with what is held ----------------------------------------------------------------------------

/// Fills body.contacts with a row for every static or kinematic surface that a point may reach in the coming
/// tick, before it touches. Bullet's broadphase names the partners. Static ones are taken apart
/// (held_pieces.cpp): where all that a point may reach is flat it has rows of planes, else rows that follow
/// the surface within the tick. On kinematic ones that move, Bullet's narrowphase finds planes; slow points
/// keep that of the last tick (PointMass::cachedContact). What moves by itself is in gatherPairs(). Call
/// after gatherPoints().
void gatherContacts(SoftBodyData& body, btScalar tick);

/// Makes body.watch, which finds what a point meets that gets farther within a tick than gatherContacts() has
/// looked for: springs and neighbours may throw it. It is on while something is near.
void addContactWatch(SoftBodyData& body);

/// After a step without the watch: whether a point that got out of its reach may have met something. Then the
/// body must be stepped again, with the watch.
bool mayHaveMissedContacts(SoftBodyData& body);

/// Rows of one point on the static partners of its body, as far as it may reach in the tick (s).
void addStaticRows(SoftBodyData& body, std::uint32_t i, const SearchRegion& searchRegion, btScalar tick);

/// Rows on a partner that moves as told; of a point that starts with a velocity and moves for `time` s of the
/// tick. `stamp`: stampOf() the partner.
void addRows(SoftBodyData& body, std::uint32_t i, const btCollisionObject& partner, std::uint64_t stamp,
             const Eigen::Vector3d& velocity, double time, btScalar tick);

/// Tells a convex partner as it is now from any other, and from itself with another shape: objects and shapes
/// may be changed, or deleted and others made in their place, and some broadphases use their ids again. 0:
/// not convex.
std::uint64_t stampOf(const btCollisionObject& partner);

// --- contacts with what moves by itself --------------------------------------------------------------------

/// Adds to `found` a contact for every surface of a rigid body that moves by itself and that a point of the
/// body may reach in the coming tick, before it touches: Bullet's narrowphase finds it. A partner that is
/// asleep is woken.
void gatherPairs(SoftBodyData& body, btRigidBody& partner, btScalar tick, TickContacts& found);

/// Adds a contact for every two point masses in the world, of different bodies, that may meet in the coming
/// tick. Call it when all awake groups have been gathered.
void gatherPointPairs(const std::vector<LinkedGroup>& groups, btScalar tick, TickContacts& found);

// --- boxes -------------------------------------------------------------------------------------------------

/// The place on a box that is nearest to a point (m, in the world), and the unit normal there, from the box
/// to the point, or outward where the point is inside.
struct NearestOnBox {
  Eigen::Vector3d surface, normal;
};

/// In closed form. Bullet's general narrowphase rounds the box's edges with the shape's margin, usually 4 cm:
/// a point could be centimetres inside what is drawn, and what the edges and triangles of a surface meet. In
/// single precision it also now and then finds a point that rests on a box centimetres above it.
inline NearestOnBox nearestOnBox(const btBoxShape& box, const btTransform& pose,
                                 const Eigen::Vector3d& point) {
  const Eigen::Vector3d half = toEigen(box.getHalfExtentsWithMargin());
  const Eigen::Vector3d local = toEigen(pose.invXform(toBullet(point)));
  Eigen::Vector3d surface = local.cwiseMax(-half).cwiseMin(half);
  Eigen::Vector3d outward = local - surface;
  if (outward.isZero(0.0)) {
    Eigen::Index axis;
    (half - local.cwiseAbs()).minCoeff(&axis);
    const double side = local[axis] < 0.0 ? -1.0 : 1.0;
    outward = side * Eigen::Vector3d::Unit(axis);
    surface[axis] = side * half[axis];
  }
  const btVector3 normal = pose.getBasis() * toBullet(Eigen::Vector3d(outward.normalized()));
  return {toEigen(pose * toBullet(surface)), toEigen(normal).normalized()};
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
