// SPDX-License-Identifier: Zlib
#include "bullet/continuous_collision.h"

#include "bullet/contact_filter.h"
#include "bullet/convert.h"
#include "bullet/kinematic_motion.h"

#include <algorithm>
#include <cmath>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {
namespace {

/// Share of the radius that a point may move in a tick without more: its centre then stays on the right side
/// of whatever it has not touched yet.
constexpr double kCarelessMotion = 0.25;

/// Share of the radius that is swept, so that a point at rest does not hit what it lies on.
constexpr double kSweptRadius = 0.9;

/// What a body might have passed through in a tick.
struct InTheWay final : btBroadphaseAabbCallback {
  explicit InTheWay(const SoftBodyData& b) : body(&b) {}
  const SoftBodyData* body;
  bool points = false;  ///< of other bodies: seen by Bullet's solver only
  bool others = false;  ///< bound the points in the substeps, as far as they were expected to get

  bool process(const btBroadphaseProxy* proxy) override {
    if (!canHit(*body, *proxy)) return true;
    const auto* object = static_cast<const btCollisionObject*>(proxy->m_clientObject);
    (PointMass::from(object) ? points : others) = true;
    return true;
  }
};

struct FirstHit final : btCollisionWorld::ClosestConvexResultCallback {
  FirstHit(const SoftBodyData& b, const PointMass& p, const btVector3& from, const btVector3& to,
           bool everything)
      : ClosestConvexResultCallback(from, to), body(&b), point(&p), all(everything) {}
  const SoftBodyData* body;
  const PointMass* point;
  bool all;  ///< else point masses alone

  bool needsCollision(btBroadphaseProxy* proxy) const override {
    const auto* object = static_cast<const btCollisionObject*>(proxy->m_clientObject);
    if ((!all && !PointMass::from(object)) || isAhead(*object)) return false;
    return canHit(*body, *proxy) && canHit(*body, *point, *object);
  }
};

double motion(const SoftBodyData& body, Eigen::Index i) {
  return (body.state.position.col(i) - body.masses.startPosition.col(i)).norm();
}

InTheWay lookInTheWay(const SoftBodyData& body, double longest) {
  const Points& from = body.masses.startPosition;
  const double margin = double(body.masses.shape->getRadius()) + longest;
  const Eigen::Vector3d low = from.rowwise().minCoeff().array() - margin;
  const Eigen::Vector3d high = from.rowwise().maxCoeff().array() + margin;
  InTheWay found(body);
  body.world->getBroadphase()->aabbTest(toBullet(low), toBullet(high), found);
  return found;
}

double radiusOf(const PointMass& point) {
  return double(static_cast<const btSphereShape*>(point.getCollisionShape())->getRadius());
}

/// The share of the way after which two points overlap by so much of the smaller radius that Bullet finds them in
/// contact, and its solver has what is needed to part them; 1 if they do so already, and it must find their speed.
double shareUntilOverlap(const btVector3& offset, const btVector3& way, double radius, double otherRadius) {
  const double distance = radius + otherRadius - (1.0 - kSweptRadius) * std::min(radius, otherRadius);
  // |offset + f way| = distance
  const Eigen::Vector3d from = toEigen(offset), along = toEigen(way);
  const double a = along.squaredNorm(), b = from.dot(along), c = from.squaredNorm() - distance * distance;
  const double root = b * b - a * c;
  if (c <= 0.0 || b >= 0.0 || root <= 0.0) return 1.0;
  return std::min(1.0, c / (std::sqrt(root) - b));
}

void sweepPoint(SoftBodyData& body, Eigen::Index i, bool all) {
  const PointMass& point = *body.masses.bodies[static_cast<std::size_t>(i)];
  const Eigen::Vector3d start = body.masses.startPosition.col(i), end = body.state.position.col(i);
  btTransform from(btQuaternion::getIdentity(), toBullet(start)),
      to(btQuaternion::getIdentity(), toBullet(end));
  FirstHit hit(body, point, from.getOrigin(), to.getOrigin(), all);
  const btSphereShape sphere(static_cast<btScalar>(kSweptRadius) * body.masses.shape->getRadius());
  body.world->convexSweepTest(&sphere, from, to, hit, btScalar(0));
  if (!hit.hasHit() || !(toEigen(hit.m_hitNormalWorld).dot(end - start) < 0.0)) return;
  double share = double(hit.m_closestHitFraction);
  if (const PointMass* other = PointMass::from(hit.m_hitCollisionObject))
    share = shareUntilOverlap(from.getOrigin() - other->getWorldTransform().getOrigin(),
                              to.getOrigin() - from.getOrigin(), radiusOf(point), radiusOf(*other));
  body.state.position.col(i) = start + share * (end - start);
}

}  // namespace

void stopAtFirstContact(SoftBodyData& body) {
  if (!body.settings.continuousCollision) return;
  const double careless = kCarelessMotion * double(body.masses.shape->getRadius());
  double longest = 0.0;
  for (Eigen::Index i = 0; i < body.state.position.cols(); ++i)
    if (!body.masses.held[static_cast<std::size_t>(i)]) longest = std::max(longest, motion(body, i));
  if (!(longest > careless)) return;
  const InTheWay found = lookInTheWay(body, longest);
  if (!found.points && !found.others) return;
  for (Eigen::Index i = 0; i < body.state.position.cols(); ++i) {
    if (body.masses.held[static_cast<std::size_t>(i)]) continue;
    const double way = motion(body, i);
    const bool unexpected = found.others && way > body.reach[static_cast<std::size_t>(i)];
    if (way > careless && (found.points || unexpected)) sweepPoint(body, i, unexpected);
  }
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
