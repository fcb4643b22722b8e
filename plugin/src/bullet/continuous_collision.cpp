// SPDX-License-Identifier: Zlib
#include "bullet/continuous_collision.h"

#include "bullet/convert.h"

#include <cmath>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {
namespace {

/// Share of the radius that a point may move in a tick without being swept: its centre then stays on the right
/// side of whatever it has not touched yet.
constexpr double kUnsweptMotion = 0.5;

/// Share of the radius at which a sweep calls it a hit, so that a resting point is not one.
constexpr double kSweptRadius = 0.9;

/// Looks for anything the body could hit.
struct OtherFinder final : btBroadphaseAabbCallback {
  const SoftBodyData* body = nullptr;
  bool found = false;

  bool process(const btBroadphaseProxy* proxy) override {
    const auto* object = static_cast<const btCollisionObject*>(proxy->m_clientObject);
    const PointMass* point = PointMass::from(object);
    const bool own = point && point->owner() == body;
    const bool filtered = !(proxy->m_collisionFilterGroup & body->settings.collisionMask) ||
                          !(proxy->m_collisionFilterMask & body->settings.collisionGroup);
    found = found || (!own && !filtered && object->hasContactResponse());
    return !found;
  }
};

double longestMotion(const SoftBodyData& body) {
  return std::sqrt((body.state.position - body.masses.startPosition).colwise().squaredNorm().maxCoeff());
}

bool somethingInTheWay(const SoftBodyData& body, double motion) {
  const Points& from = body.masses.startPosition;
  const double margin = double(body.masses.shape->getRadius()) + motion;
  const Eigen::Vector3d low = from.rowwise().minCoeff().array() - margin;
  const Eigen::Vector3d high = from.rowwise().maxCoeff().array() + margin;
  OtherFinder finder;
  finder.body = &body;
  body.world->getBroadphase()->aabbTest(toBullet(low), toBullet(high), finder);
  return finder.found;
}

/// Bullet counts a hit only once the swept sphere is m_allowedCcdPenetration (4 cm by default) deep, more than a
/// point mass is large: the swept radius makes up for it.
void setSweeping(SoftBodyData& body, bool on) {
  const double radius = double(body.masses.shape->getRadius());
  const double allowed = double(body.world->getDispatchInfo().m_allowedCcdPenetration);
  for (PointMass* point : body.masses.bodies) {
    point->setCcdMotionThreshold(on ? static_cast<btScalar>(kUnsweptMotion * radius) : btScalar(0));
    point->setCcdSweptSphereRadius(on ? static_cast<btScalar>(kSweptRadius * radius + allowed) : btScalar(0));
  }
  body.swept = on;
}

}  // namespace

void chooseContinuousCollision(SoftBodyData& body) {
  if (!body.settings.continuousCollision) return;
  const double motion = longestMotion(body);
  const bool needed =
      motion > kUnsweptMotion * double(body.masses.shape->getRadius()) && somethingInTheWay(body, motion);
  if (needed || body.swept) setSweeping(body, needed);
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
