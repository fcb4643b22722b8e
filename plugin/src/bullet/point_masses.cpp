// SPDX-License-Identifier: Zlib
#include "bullet/point_masses.h"

#include "bullet/convert.h"
#include "bullet/soft_body_data.h"
#include "core/coincident_points.h"

#include <cmath>
#include <limits>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {
namespace {

/// Roundings Bullet makes between what we hand over and what we read back; differences up to this many units
/// in the last place are not an impulse.
constexpr double kRoundings = 4.0;
constexpr double kEpsilon = std::numeric_limits<btScalar>::epsilon();

PointMass* makeBody(SoftBodyData& body, std::uint32_t i) {
  const btScalar mass = static_cast<btScalar>(body.settings.totalMass * body.network->massShares[i]);
  // no inertia: a point mass does not spin, and so slides with its full friction
  btRigidBody::btRigidBodyConstructionInfo info(mass, nullptr, body.masses.shape.get(), btVector3(0, 0, 0));
  info.m_startWorldTransform.setIdentity();
  info.m_startWorldTransform.setOrigin(toBullet(Eigen::Vector3d(body.state.position.col(i))));
  info.m_friction = static_cast<btScalar>(body.settings.friction);
  info.m_restitution = static_cast<btScalar>(body.settings.restitution);
  auto* point = new PointMass(info, &body, i);
  point->setAngularFactor(btScalar(0));
  point->setFlags(point->getFlags() & ~BT_ENABLE_GYROSCOPIC_FORCE_IMPLICIT_BODY);
  point->setCollisionFlags(point->getCollisionFlags() | btCollisionObject::CF_DISABLE_VISUALIZE_OBJECT);
  point->setLinearVelocity(toBullet(Eigen::Vector3d(body.state.velocity.col(i))));
  point->setSleepingThresholds(static_cast<btScalar>(body.settings.sleepingSpeed),
                               point->getAngularSleepingThreshold());
  return point;
}

/// Records what is in the Bullet body now, so that later changes are seen.
void remember(PointMasses& masses, std::uint32_t i) {
  masses.leftPosition[i] = masses.bodies[i]->getWorldTransform().getOrigin();
  masses.leftVelocity[i] = masses.bodies[i]->getLinearVelocity();
}

Eigen::Vector3d difference(const btVector3& now, const btVector3& before) {
  return toEigen(now) - toEigen(before);
}

void gatherHeld(SoftBodyData& body, std::uint32_t i, btScalar tick) {
  PointState& s = body.state;
  const btVector3& target = body.masses.bodies[i]->getWorldTransform().getOrigin();
  s.velocity.col(i) = (toEigen(target) - s.position.col(i)) / double(tick);
  s.acceleration.col(i).setZero();
}

void absorbChange(SoftBodyData& body, std::uint32_t i) {
  body.state.position.col(i) = currentPosition(body, i);
  body.state.velocity.col(i) = currentVelocity(body, i);
  remember(body.masses, i);
}

void gatherFree(SoftBodyData& body, std::uint32_t i) {
  absorbChange(body, i);
  const PointMass& point = *body.masses.bodies[i];
  body.state.acceleration.col(i) = toEigen(point.getTotalForce()) * double(point.getInvMass());
}

Eigen::Vector3d inverseMass(const PointMass& point, bool held) {
  if (held) return Eigen::Vector3d::Zero();
  return toEigen(point.getLinearFactor()) * double(point.getInvMass());
}

/// Held by pin(), by the user (static or kinematic), or taken out of the simulation by Bullet or the user.
bool isHeld(const PointMass& point) {
  return point.isStaticOrKinematicObject() || point.getActivationState() == DISABLE_SIMULATION;
}

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

void writeBody(SoftBodyData& body, std::uint32_t i) {
  PointMass& point = *body.masses.bodies[i];
  const btVector3 position = toBullet(Eigen::Vector3d(body.state.position.col(i)));
  const btVector3 velocity = toBullet(Eigen::Vector3d(body.state.velocity.col(i)));
  point.getWorldTransform().setOrigin(position);
  point.getInterpolationWorldTransform().setOrigin(position);
  point.setLinearVelocity(velocity);
  point.setInterpolationLinearVelocity(velocity);
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
  const std::size_t count = body.network->restPoints.size();
  PointMasses& m = body.masses;
  m.shape = std::make_unique<PointSphere>(static_cast<btScalar>(pointRadius(*body.network, body.settings)));
  m.bodies.assign(count, nullptr);
  m.leftPosition.assign(count, btVector3(0, 0, 0));
  m.leftVelocity = m.expectedVelocity = m.leftPosition;
  m.held.assign(count, 0);
  m.startPosition = body.state.position;
  for (std::uint32_t i = 0; i < count; ++i) {
    m.bodies[i] = makeBody(body, i);
    body.world->addRigidBody(m.bodies[i], body.settings.collisionGroup, body.settings.collisionMask);
    body.state.inverseMass.col(i) = inverseMass(*m.bodies[i], false);
    remember(m, i);
  }
}

void removePointMasses(SoftBodyData& body) {
  // from the back: Bullet finds a body in its list of dynamic ones by a linear search and swaps in the last
  for (std::size_t i = body.masses.bodies.size(); i-- > 0;) {
    PointMass* point = body.masses.bodies[i];
    if (!point) continue;
    point->setOwner(nullptr);
    // the broadphase handle goes with the world: a body without one must not touch it
    if (point->isInWorld()) body.world->removeRigidBody(point);
    delete point;
    body.masses.bodies[i] = nullptr;
  }
}

void forgetDeletedPoint(SoftBodyData& body, std::uint32_t index) {
  const PointMass* point = body.masses.bodies[index];
  body.masses.bodies[index] = nullptr;
  body.alive = false;
  if (body.onPointDeleted) body.onPointDeleted(*point);
}

void gatherPoints(SoftBodyData& body, btScalar tick) {
  PointMasses& m = body.masses;
  bool moved = false;
  for (std::uint32_t i = 0; i < m.bodies.size(); ++i) {
    PointMass& point = *m.bodies[i];
    point.keepCollisionFilter();
    const bool held = isHeld(point);
    moved = moved || (!held && point.getWorldTransform().getOrigin() != m.leftPosition[i]);
    if (held)
      gatherHeld(body, i, tick);
    else
      gatherFree(body, i);
    const Eigen::Vector3d w = inverseMass(point, held);
    if (w != body.state.inverseMass.col(i)) {
      body.frequencyStale = true;
      body.springs.damperTime = 0.0;
    }
    body.state.inverseMass.col(i) = w;
    m.held[i] = held;
    remember(m, i);
  }
  // neither the steps themselves nor a pin that is moved about bring points to exactly one place
  if (moved) separateCoincident(body.springs, body.state);
  m.startPosition = body.state.position;
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

void takeBackContacts(SoftBodyData& body, btScalar tick) {
  for (std::uint32_t i = 0; i < body.masses.bodies.size(); ++i)
    if (!body.masses.held[i]) takeBackFree(body, i, tick);
}

void writePoints(SoftBodyData& body) {
  for (std::uint32_t i = 0; i < body.masses.bodies.size(); ++i) {
    if (!body.masses.held[i]) writeBody(body, i);
    remember(body.masses, i);
  }
}

void absorbOutsideChanges(SoftBodyData& body) {
  for (std::uint32_t i = 0; i < body.masses.bodies.size(); ++i)
    if (body.masses.bodies[i] && !body.masses.held[i]) absorbChange(body, i);
}

bool isMoving(const SoftBodyData& body, std::uint32_t i, btScalar tick) {
  const PointMasses& m = body.masses;
  const PointMass& point = *m.bodies[i];
  const bool changedOutside = point.getWorldTransform().getOrigin() != m.leftPosition[i] ||
                              point.getLinearVelocity() != m.leftVelocity[i];
  const double way = (body.state.position.col(i) - m.startPosition.col(i)).norm();
  return changedOutside || way > double(point.getLinearSleepingThreshold() * tick);
}

Eigen::Vector3d currentPosition(const SoftBodyData& body, std::uint32_t i) {
  const PointMass* point = body.masses.bodies[i];
  if (!point) return body.state.position.col(i);
  return body.state.position.col(i) +
         difference(point->getWorldTransform().getOrigin(), body.masses.leftPosition[i]);
}

Eigen::Vector3d currentVelocity(const SoftBodyData& body, std::uint32_t i) {
  const PointMass* point = body.masses.bodies[i];
  if (!point || body.masses.held[i]) return body.state.velocity.col(i);
  return body.state.velocity.col(i) + difference(point->getLinearVelocity(), body.masses.leftVelocity[i]);
}

void setPinned(SoftBodyData& body, std::uint32_t i, bool pinned) {
  PointMass* point = body.masses.bodies[i];
  if (!point) return;
  const int kinematic = btCollisionObject::CF_KINEMATIC_OBJECT;
  const btScalar mass = static_cast<btScalar>(body.settings.totalMass * body.network->massShares[i]);
  // setMassProps(0) marks the body static; as a kinematic one it may also be moved
  point->setMassProps(pinned ? btScalar(0) : mass, btVector3(0, 0, 0));
  const int flags = point->getCollisionFlags() & ~(kinematic | btCollisionObject::CF_STATIC_OBJECT);
  point->setCollisionFlags(pinned ? flags | kinematic : flags);
  body.state.velocity.col(i) = pinned ? Eigen::Vector3d::Zero() : Eigen::Vector3d(body.state.velocity.col(i));
  point->setLinearVelocity(toBullet(Eigen::Vector3d(body.state.velocity.col(i))));
  body.masses.held[i] = pinned;
  remember(body.masses, i);
}

void wakePoints(SoftBodyData& body, bool insideTick) {
  for (PointMass* point : body.masses.bodies) {
    if (!point || point->isActive()) continue;
    point->activate(true);
    // the world has already given gravity to those that were awake at the start of the step
    if (insideTick) point->applyGravity();
  }
  body.asleep = false;
  body.calmTime = 0.0;
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
