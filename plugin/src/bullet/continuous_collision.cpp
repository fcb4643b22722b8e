// SPDX-License-Identifier: Zlib
#include "bullet/continuous_collision.h"

#include "bullet/contact_filter.h"
#include "bullet/convert.h"

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
  bool dynamic = false;     ///< seen by Bullet's solver only, which does not see points outside the world
  bool nonDynamic = false;  ///< bounds the points in the substeps, as far as they were expected to get

  bool process(const btBroadphaseProxy* proxy) override {
    if (!canHit(*body, *proxy)) return true;
    const bool moves =
        !static_cast<const btCollisionObject*>(proxy->m_clientObject)->isStaticOrKinematicObject();
    if (!moves || !body->surface.object) (moves ? dynamic : nonDynamic) = true;
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
    if (body->surface.object && !object->isStaticOrKinematicObject()) return false;
    return canHit(*body, *proxy) && point->checkCollideWith(object) && object->checkCollideWith(point);
  }
};

double motion(const SoftBodyData& body, Eigen::Index i) {
  return (body.state.position.col(i) - body.masses.startPosition.col(i)).norm();
}

/// Whether a point got farther than contacts were looked for.
bool anyOutOfReach(const SoftBodyData& body) {
  for (Eigen::Index i = 0; i < body.state.position.cols(); ++i) {
    const double reach = body.reach[static_cast<std::size_t>(i)];
    if ((body.state.position.col(i) - body.masses.startPosition.col(i)).squaredNorm() > reach * reach)
      return true;
  }
  return false;
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

void sweepPoint(SoftBodyData& body, Eigen::Index i) {
  const PointMass& point = *body.masses.bodies[static_cast<std::size_t>(i)];
  const Eigen::Vector3d start = body.masses.startPosition.col(i), end = body.state.position.col(i);
  btTransform from(btQuaternion::getIdentity(), toBullet(start)),
      to(btQuaternion::getIdentity(), toBullet(end));
  FirstHit hit(body, point, from.getOrigin(), to.getOrigin());
  const btSphereShape sphere(static_cast<btScalar>(kSweptRadius) * body.masses.shape->getRadius());
  body.world->convexSweepTest(&sphere, from, to, hit, btScalar(0));
  const bool intoIt = hit.hasHit() && toEigen(hit.m_hitNormalWorld).dot(end - start) < 0.0;
  if (intoIt) body.state.position.col(i) = start + double(hit.m_closestHitFraction) * (end - start);
}

}  // namespace

void stopAtFirstContact(SoftBodyData& body) {
  if (!body.settings.continuousCollision) return;
  const double careless = kCarelessMotion * double(body.masses.shape->getRadius());
  if (body.surface.object && !anyOutOfReach(body)) return;
  double longest = 0.0;
  for (Eigen::Index i = 0; i < body.state.position.cols(); ++i)
    if (!body.masses.held[static_cast<std::size_t>(i)]) longest = std::max(longest, motion(body, i));
  if (!(longest > careless)) return;
  const InTheWay found = lookInTheWay(body, longest);
  if (!found.dynamic && !found.nonDynamic) return;
  for (Eigen::Index i = 0; i < body.state.position.cols(); ++i) {
    if (body.masses.held[static_cast<std::size_t>(i)]) continue;
    const double way = motion(body, i);
    const bool unexpected = found.nonDynamic && way > body.reach[static_cast<std::size_t>(i)];
    if (way > careless && (found.dynamic || unexpected)) sweepPoint(body, i);
  }
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
