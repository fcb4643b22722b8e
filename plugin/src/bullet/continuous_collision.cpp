// SPDX-License-Identifier: Zlib
#include "bullet/continuous_collision.h"

#include "bullet/bullet_objects.h"
#include "bullet/contact_filter.h"
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

/// Whether there is something that a body might have passed through in a tick.
struct InTheWay final : btBroadphaseAabbCallback {
  explicit InTheWay(const SoftBodyData& b) : body(&b) {}
  const SoftBodyData* body;
  bool any = false;

  bool process(const btBroadphaseProxy* proxy) override {
    any = any || canHit(*body, *proxy);
    return true;
  }
};

struct FirstHit final : btCollisionWorld::ClosestConvexResultCallback {
  FirstHit(const SoftBodyData& b, const PointMass& p, const btVector3& from, const btVector3& to)
      : ClosestConvexResultCallback(from, to), body(&b), point(&p) {}
  const SoftBodyData* body;
  const PointMass* point;

  bool needsCollision(btBroadphaseProxy* proxy) const override {
    const auto* object = static_cast<const btCollisionObject*>(proxy->m_clientObject);
    return !isAhead(*object) && canHit(*body, *proxy) && canHit(*body, *point, *object);
  }
};

double motion(const SoftBodyData& body, Eigen::Index i) {
  return (body.state.position.col(i) - body.masses.startPosition.col(i)).norm();
}

bool isAnythingInTheWay(const SoftBodyData& body, double longest) {
  const Points& from = body.masses.startPosition;
  const double margin = double(body.masses.shape->getRadius()) + longest;
  const Eigen::Vector3d low = from.rowwise().minCoeff().array() - margin;
  const Eigen::Vector3d high = from.rowwise().maxCoeff().array() + margin;
  InTheWay found(body);
  body.world->getBroadphase()->aabbTest(toBullet(low), toBullet(high), found);
  return found.any;
}

void sweepPoint(SoftBodyData& body, Eigen::Index i) {
  const PointMass& point = *body.masses.bodies[static_cast<std::size_t>(i)];
  const Eigen::Vector3d start = body.masses.startPosition.col(i), end = body.state.position.col(i);
  btTransform from(btQuaternion::getIdentity(), toBullet(start)),
      to(btQuaternion::getIdentity(), toBullet(end));
  FirstHit hit(body, point, from.getOrigin(), to.getOrigin());
  const btSphereShape sphere(static_cast<btScalar>(kSweptRadius) * body.masses.shape->getRadius());
  body.world->convexSweepTest(&sphere, from, to, hit, btScalar(0));
  if (!hit.hasHit() || !(toEigen(hit.m_hitNormalWorld).dot(end - start) < 0.0)) return;
  body.state.position.col(i) = start + double(hit.m_closestHitFraction) * (end - start);
}

}  // namespace

void stopAtFirstContact(SoftBodyData& body) {
  if (!body.settings.continuousCollision) return;
  const double careless = kCarelessMotion * double(body.masses.shape->getRadius());
  const auto isUnexpected = [&](Eigen::Index i) {
    const auto at = static_cast<std::size_t>(i);
    return !body.masses.held[at] && motion(body, i) > std::max(careless, body.reach[at]);
  };
  double longest = 0.0;
  for (Eigen::Index i = 0; i < body.state.position.cols(); ++i)
    if (isUnexpected(i)) longest = std::max(longest, motion(body, i));
  if (!(longest > 0.0) || !isAnythingInTheWay(body, longest)) return;
  for (Eigen::Index i = 0; i < body.state.position.cols(); ++i)
    if (isUnexpected(i)) sweepPoint(body, i);
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
