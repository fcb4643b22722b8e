// SPDX-License-Identifier: Zlib
#include "bullet/world_points.h"

#include "bullet/bullet_objects.h"
#include "bullet/continuous_collision.h"

#include <cmath>
#include <limits>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {
namespace {

/// Roundings Bullet makes between what we hand over and what we read back; differences up to this many units
/// in the last place are not an impulse.
constexpr double kRoundings = 4.0;
constexpr double kEpsilon = std::numeric_limits<btScalar>::epsilon();

/// The velocity Bullet's solver leaves when nothing touches the body, in its own arithmetic:
/// btSequentialImpulseConstraintSolver adds (force * inverse mass) * time step.
btVector3 untouchedVelocity(const PointMass& point, const btVector3& handed, btScalar tick) {
  return handed + point.getTotalForce() * point.getInvMass() * tick;
}

/// Zero where `v` is no larger than the rounding of quantities as large as `scale`.
Eigen::Vector3d withoutRounding(const Eigen::Vector3d& v, double scale) {
  const double noise = kRoundings * kEpsilon * scale;
  return v.cwiseAbs().maxCoeff() <= noise ? Eigen::Vector3d::Zero() : v;
}

void takeBackFree(SoftBodyData& body, std::uint32_t i, btScalar tick) {
  const PointMass& point = *body.masses.bodies[i];
  const btVector3& expected = body.masses.expectedVelocity[i];
  const btVector3& start = body.masses.leftPosition[i];
  const btVector3& origin = point.getWorldTransform().getOrigin();
  const btVector3& velocity = point.getLinearVelocity();

  const double speed = toEigen(expected).cwiseAbs().maxCoeff();
  const Eigen::Vector3d impulse = withoutRounding(difference(velocity, expected), speed);
  const Eigen::Vector3d unexplained = difference(origin, start) - double(tick) * toEigen(velocity);
  const double size = toEigen(origin).cwiseAbs().maxCoeff() + double(tick) * toEigen(velocity).norm();
  body.state.velocity.col(i) += impulse;
  body.state.position.col(i) += double(tick) * impulse + withoutRounding(unexplained, size);
}

}  // namespace

void addPointMasses(SoftBodyData& body) {
  makePointMasses(body);
  for (PointMass* point : body.masses.bodies)
    body.world->addRigidBody(point, body.settings.collisionGroup, body.settings.collisionMask);
}

void removePointMasses(SoftBodyData& body) {
  // from the back: Bullet finds a body in its list of dynamic ones by a linear search and swaps in the last
  for (std::size_t i = body.masses.bodies.size(); i-- > 0;) {
    PointMass* point = body.masses.bodies[i];
    // the broadphase handle goes with the world: a body without one must not touch it
    if (point && point->isInWorld()) body.world->removeRigidBody(point);
  }
  deletePointMasses(body);
}

void gatherWorldPoints(SoftBodyData& body, btScalar tick) {
  gatherPoints(body, tick, false);
  for (std::uint32_t i = 0; i < body.masses.bodies.size(); ++i) {
    PointMass& point = *body.masses.bodies[i];
    if (!isSound(point.getTotalForce())) {
      point.clearForces();
      point.applyGravity();
      body.restored = true;
    }
    body.state.acceleration.col(i) = toEigen(point.getTotalForce()) * double(point.getInvMass());
    if (body.masses.held[i]) body.state.acceleration.col(i).setZero();
  }
}

void handOverVelocities(SoftBodyData& body, btScalar tick) {
  PointMasses& m = body.masses;
  for (std::uint32_t i = 0; i < m.bodies.size(); ++i) {
    if (m.held[i]) continue;
    PointMass& point = *m.bodies[i];
    const Eigen::Vector3d mean = (body.state.position.col(i) - m.startPosition.col(i)) / double(tick);
    const btVector3 handed = toBullet(Eigen::Vector3d(mean - double(tick) * body.state.acceleration.col(i)));
    point.setLinearVelocity(handed);
    m.expectedVelocity[i] = untouchedVelocity(point, handed, tick);
  }
}

void finishWorldPoints(SoftBodyData& body, btScalar tick) {
  for (PointMass* point : body.masses.bodies) point->setContactProcessingThreshold(BT_LARGE_FLOAT);
  for (std::uint32_t i = 0; i < body.masses.bodies.size(); ++i)
    if (!body.masses.held[i]) takeBackFree(body, i, tick);
  restoreIfUnsound(body);
  stopAtFirstContact(body);
  writePoints(body);
}

void wakeWorldPoints(SoftBodyData& body, bool insideTick) {
  for (PointMass* point : body.masses.bodies) {
    if (!point || point->isActive()) continue;
    point->activate(true);
    // the world has already given gravity to those that were awake at the start of the step
    if (insideTick) point->applyGravity();
  }
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
