// SPDX-License-Identifier: Zlib

// This file makes, reads and writes the Bullet bodies of points. It copies the user's changes of the bodies
// to the state, and the rounded state to the bodies.

#include "bullet/point_masses.h"

#include "bullet/body_in_world.h"

#include <cmath>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

PointMass::PointMass(const btRigidBodyConstructionInfo& info, SoftBodyData* owner, std::uint32_t index)
    : OwnBody(info), owner_(owner), index_(index) {
  keepCollisionFilter();
}

/// The application deletes the point if it still has an owner.
PointMass::~PointMass() {
  if (!owner_) return;
  owner_->masses.bodies[index_] = nullptr;
  owner_->alive = false;
  if (owner_->surface.object) owner_->surface.object->forceActivationState(DISABLE_SIMULATION);
  if (owner_->onPointDeleted) owner_->onPointDeleted(*this);
}

bool PointMass::checkCollideWithOverride(const btCollisionObject* other) const {
  if (owner_ && isAttached(*owner_, index_, *other)) return false;
  const PointMass* point = from(other);
  if (point && point->owner_ == owner_ && owner_) return false;
  return btRigidBody::checkCollideWithOverride(other);
}

const char* PointMass::serialize(void* data, btSerializer* serializer) const {
  if (owner_ && owner_->alive && index_ == 0) writeChunk(*owner_, *serializer);
  const char* type = btRigidBody::serialize(data, serializer);
  static_cast<btRigidBodyData*>(data)->m_collisionObjectData.m_collisionShape = nullptr;
  return type;
}

// --- the points of one body --------------------------------------------------------------------------------

void remember(PointMasses& masses, std::uint32_t i) {
  masses.leftPosition[i] = masses.bodies[i]->getWorldTransform().getOrigin();
  masses.leftVelocity[i] = masses.bodies[i]->getLinearVelocity();
}

namespace {

/// Returns whether the bodies differ from the state only where the application has changed them.
bool isReadable(const PointMasses& masses) { return masses.exposed && !masses.inFlight; }

/// Returns a very large inertia, which prevents rotation also in solvers that ignore the angular factor. The
/// angular factor of a point mass is 0: it does not rotate and slides with its full friction. An inverse
/// inertia of 0 is not possible: if Bullet solved an unpredicted contact with an object at rest, its rolling
/// friction would divide by zero.
btVector3 inertiaOf(const SoftBodyData& body, btScalar mass) {
  constexpr btScalar kMuch = btScalar(1e4);
  const btScalar radius = body.masses.shape->getRadius(), inertia = kMuch * mass * radius * radius;
  return btVector3(inertia, inertia, inertia);
}

btScalar settingsMassOf(const SoftBodyData& body, std::uint32_t i) {
  return static_cast<btScalar>(body.model->masses[i]);
}

PointMass* makeBody(SoftBodyData& body, std::uint32_t i) {
  const btScalar mass = settingsMassOf(body, i);
  btRigidBody::btRigidBodyConstructionInfo info(mass, nullptr, body.masses.shape.get(),
                                                inertiaOf(body, mass));
  info.m_startWorldTransform.setIdentity();
  info.m_startWorldTransform.setOrigin(toBullet(body.state.position.col(i)));
  info.m_friction = static_cast<btScalar>(body.settings.friction);
  info.m_restitution = static_cast<btScalar>(body.settings.restitution);
  auto* point = new PointMass(info, &body, i);
  point->setAngularFactor(btScalar(0));
  point->setFlags(point->getFlags() & ~BT_ENABLE_GYROSCOPIC_FORCE_IMPLICIT_BODY);
  point->setCollisionFlags(point->getCollisionFlags() | btCollisionObject::CF_DISABLE_VISUALIZE_OBJECT);
  point->setLinearVelocity(toBullet(body.state.velocity.col(i)));
  point->setSleepingThresholds(static_cast<btScalar>(body.settings.sleepingSpeed),
                               point->getAngularSleepingThreshold());
  return point;
}

void gatherHeld(SoftBodyData& body, std::uint32_t i, btScalar tick) {
  PointState& s = body.state;
  btVector3& target = body.masses.bodies[i]->getWorldTransform().getOrigin();
  if (!isSound(target)) {
    target = body.masses.leftPosition[i];
    body.restored = true;
  }
  s.velocity.col(i) = (toEigen(target) - s.position.col(i)) / double(tick);
  const double speed = s.velocity.col(i).norm();
  if (speed > body.settings.maxPinSpeed) s.velocity.col(i) *= body.settings.maxPinSpeed / speed;
}

/// Copies the user's changes of a point to the state. First restores values that are not sound, because they
/// would spread to other points.
void absorbChange(SoftBodyData& body, std::uint32_t i) {
  const PointMass& point = *body.masses.bodies[i];
  if (!isSound(point.getWorldTransform().getOrigin()) || !isSound(point.getLinearVelocity())) {
    writePoint(body, i);
    body.restored = true;
  }
  body.state.position.col(i) = currentPosition(body, i);
  body.state.velocity.col(i) = currentVelocity(body, i);
  remember(body.masses, i);
}

Eigen::Vector3d inverseMass(const PointMass& point, bool held) {
  const Eigen::Vector3d w = toEigen(point.getLinearFactor()) * double(point.getInvMass());
  return held || !w.allFinite() ? Eigen::Vector3d::Zero() : w;
}

/// Restores the inertia of a point whose mass the user has changed: users set no inertia with it.
void keepInertia(SoftBodyData& body, PointMass& point) {
  const btScalar inverseMass = point.getInvMass();
  if (!(inverseMass > btScalar(0)) || !point.getInvInertiaDiagLocal().isZero()) return;
  const btVector3 inertia = inertiaOf(body, btScalar(1) / inverseMass);
  point.setInvInertiaDiagLocal(btVector3(1, 1, 1) / inertia);
  point.updateInertiaTensor();
}

void updateInverseMass(SoftBodyData& body, std::uint32_t i) {
  keepInertia(body, *body.masses.bodies[i]);
  const Eigen::Vector3d w = inverseMass(*body.masses.bodies[i], body.masses.held[i]);
  if (w == body.state.inverseMass.col(i)) return;
  body.frequencyStale = true;
  body.springs.preparedFor = 0.0;
  ++body.springs.revision;
  body.state.inverseMass.col(i) = w;
}

/// Returns whether a point is held by pin() or by the user (static or kinematic), or was taken out of the
/// simulation by Bullet or the user.
bool isHeld(const PointMass& point) {
  return point.isStaticOrKinematicObject() || point.getActivationState() == DISABLE_SIMULATION;
}

}  // namespace

void writePoint(SoftBodyData& body, std::uint32_t i) {
  PointMass& point = *body.masses.bodies[i];
  const btVector3 position = toBullet(body.state.position.col(i));
  const btVector3 velocity = toBullet(body.state.velocity.col(i));
  point.getWorldTransform().setOrigin(position);
  point.getInterpolationWorldTransform().setOrigin(position);
  point.setLinearVelocity(velocity);
  point.setInterpolationLinearVelocity(velocity);
}

double inverseOf(double mass) {
  const auto w = double(btScalar(1) / static_cast<btScalar>(mass));
  return std::isfinite(w) ? w : 0.0;
}

void initializePointMasses(SoftBodyData& body) {
  PointMasses& m = body.masses;
  m.shape =
      std::make_unique<PointSphere>(static_cast<btScalar>(pointRadius(*body.model->network, body.settings)));
  m.held.assign(pointCount(body), 0);
  m.startPosition = body.state.position;
  for (std::uint32_t i = 0; i < pointCount(body); ++i) {
    body.state.inverseMass.col(i).setConstant(inverseOf(body.model->masses[i]));
  }
}

void makePointMasses(SoftBodyData& body) {
  PointMasses& m = body.masses;
  m.bodies.assign(pointCount(body), nullptr);
  m.leftPosition.assign(pointCount(body), btVector3(0, 0, 0));
  m.leftVelocity = m.expectedVelocity = m.leftPosition;
  for (std::uint32_t i = 0; i < pointCount(body); ++i) {
    m.bodies[i] = makeBody(body, i);
    remember(m, i);
  }
}

namespace {

/// Sets the mass of a point that was divided. A mass that the user has set is shared in the same proportion.
void shareMass(const SoftBodyData& body, PointMass& point, std::uint32_t i, btScalar present, double before) {
  const auto own = settingsMassOf(body, i);
  const auto was = static_cast<btScalar>(before);
  const btScalar shared = static_cast<btScalar>(double(present) * double(own) / before);
  const btScalar mass = present == was ? own : shared;
  if (point.isKinematicObject())
    point.massBeforePin = mass;
  else if (mass > btScalar(0))
    point.setMassProps(mass, inertiaOf(body, mass));
}

/// Makes the body of a new point like that of the point which it comes from.
PointMass* copyOf(SoftBodyData& body, std::uint32_t i, const PointMass& from) {
  PointMass* point = makeBody(body, i);
  point->setFriction(from.getFriction());
  point->setRestitution(from.getRestitution());
  point->setDamping(from.getLinearDamping(), from.getAngularDamping());
  point->setLinearFactor(from.getLinearFactor());
  point->setFlags(from.getFlags());
  point->setSleepingThresholds(from.getLinearSleepingThreshold(), from.getAngularSleepingThreshold());
  point->setUserPointer(from.getUserPointer());
  point->setUserIndex(from.getUserIndex());
  if (from.isKinematicObject()) {
    point->setMassProps(btScalar(0), btVector3(0, 0, 0));
    point->setCollisionFlags((point->getCollisionFlags() & ~btCollisionObject::CF_STATIC_OBJECT) |
                             btCollisionObject::CF_KINEMATIC_OBJECT);
    point->setWorldTransform(from.getWorldTransform());
  }
  return point;
}

void addCopyToWorld(const SoftBodyData& body, PointMass& point, const PointMass& from) {
  const btBroadphaseProxy* proxy = from.getBroadphaseHandle();
  if (from.isInWorld() && proxy && body.world)
    body.world->addRigidBody(&point, proxy->m_collisionFilterGroup, proxy->m_collisionFilterMask);
  point.setGravity(from.getGravity());
  point.forceActivationState(from.getActivationState());
}

}  // namespace

btScalar presentMass(const PointMass& point, double ofSettings) {
  const auto own = static_cast<btScalar>(ofSettings);
  if (point.isKinematicObject()) return point.massBeforePin;
  return point.getInvMass() == btScalar(1) / own ? own : point.getMass();
}

void dividePointMasses(SoftBodyData& body, const std::vector<std::uint32_t>& pointOf,
                       const std::vector<double>& massBefore) {
  PointMasses& m = body.masses;
  for (std::size_t i = m.held.size(); i < pointOf.size(); ++i) m.held.push_back(m.held[pointOf[i]]);
  if (m.bodies.empty()) return;
  for (std::uint32_t i = static_cast<std::uint32_t>(m.bodies.size()); i < pointOf.size(); ++i) {
    PointMass& from = *m.bodies[pointOf[i]];
    const double before = massBefore[pointOf[i]];
    PointMass* point = copyOf(body, i, from);
    m.bodies.push_back(point);
    shareMass(body, *point, i, presentMass(from, before), before);
    addCopyToWorld(body, *point, from);
    point->applyCentralForce(from.getTotalForce() * static_cast<btScalar>(body.model->masses[i] / before));
    for (auto* array : {&m.leftPosition, &m.leftVelocity, &m.expectedVelocity})
      array->push_back(btVector3((*array)[pointOf[i]]));
  }
  for (std::uint32_t i = 0; i < massBefore.size(); ++i) {
    if (body.model->masses[i] == massBefore[i]) continue;
    PointMass& point = *m.bodies[i];
    const btVector3 force = point.getTotalForce(), gravity = point.getGravity();
    shareMass(body, point, i, presentMass(point, massBefore[i]), massBefore[i]);
    point.setGravity(gravity);
    point.clearForces();
    point.applyCentralForce(force * static_cast<btScalar>(body.model->masses[i] / massBefore[i]));
  }
}

PointMass& probeAt(SoftBodyData& body, std::uint32_t i) {
  std::unique_ptr<PointMass>& probe = body.masses.probe;
  if (!probe) probe.reset(makeBody(body, i));
  probe->getWorldTransform().setOrigin(toBullet(body.state.position.col(i)));
  return *probe;
}

void deletePointMasses(SoftBodyData& body) {
  if (body.masses.probe) body.masses.probe->setOwner(nullptr);
  body.masses.probe.reset();
  for (PointMass*& point : body.masses.bodies) {
    if (point) point->setOwner(nullptr);
    delete point;
    point = nullptr;
  }
}

void gatherPoints(SoftBodyData& body, btScalar tick, bool allHeld) {
  PointMasses& m = body.masses;
  body.sumsValid = false;
  bool moved = m.changed;
  m.changed = m.inFlight = false;
  for (std::uint32_t i = 0; i < m.bodies.size(); ++i) {
    PointMass& point = *m.bodies[i];
    point.keepCollisionFilter();
    const bool held = allHeld || isHeld(point);
    moved = moved || (!held && point.getWorldTransform().getOrigin() != m.leftPosition[i]);
    if (held)
      gatherHeld(body, i, tick);
    else
      absorbChange(body, i);
    if (m.held[i] && !held) body.surface.freed = true;
    m.held[i] = held;
    updateInverseMass(body, i);
    remember(m, i);
  }
  // steps and moved pins never bring two points to exactly the same position, but the user may
  if (moved) separateCoincident(body.springs, body.state);
  m.startPosition = body.state.position;
}

void writePoints(SoftBodyData& body) {
  for (std::uint32_t i = 0; i < body.masses.bodies.size(); ++i) {
    if (!body.masses.held[i]) writePoint(body, i);
    remember(body.masses, i);
  }
}

void absorbOutsideChanges(SoftBodyData& body) {
  if (!body.masses.exposed || body.masses.inFlight) return;
  body.sumsValid = false;
  for (std::uint32_t i = 0; i < body.masses.bodies.size(); ++i) {
    if (!body.masses.bodies[i]) continue;
    updateInverseMass(body, i);
    if (body.masses.held[i] || !isChangedOutside(body, i)) continue;
    const Eigen::Vector3d before = body.state.position.col(i);
    absorbChange(body, i);
    // shifts the motion of the last tick, see positionAt()
    body.masses.startPosition.col(i) += body.state.position.col(i) - before;
    body.masses.changed = true;
  }
}

bool isSound(const btVector3& v) { return toEigen(v).cwiseAbs().sum() < kMaxSound; }

void restoreIfUnsound(SoftBodyData& body) {
  PointState& s = body.state;
  const double magnitude =
      body.sumsValid ? body.sums.magnitude : s.position.cwiseAbs().sum() + s.velocity.cwiseAbs().sum();
  if (magnitude < kMaxSound) return;
  body.sumsValid = false;
  s.position = body.masses.startPosition;
  s.velocity.setZero();
  if (SpringConstants* yielded = body.springs.yielded.get())
    for (std::size_t i = 0; i < yielded->restLength.size(); ++i)
      if (!std::isfinite(yielded->restLength[i]))
        yielded->restLength[i] = body.springs.original->restLength[i];
  ++body.springs.revision;
  forgetMotion(body);
  body.restored = true;
}

void forgetMotion(SoftBodyData& body) {
  for (PlaneContact& row : body.contacts) row.impulse = TickImpulse();
  body.storedImpulses.clear();
  if (body.medium) body.medium->others.reset();
  if (body.startVelocity.cols() > 0) body.startVelocity = body.state.velocity;
  body.implicit.reset();
  body.volumes.kept.value = 0.0;
  body.errorPerSecond = body.errorCoefficient = 0.0;
}

bool isChangedOutside(const SoftBodyData& body, std::uint32_t i) {
  const PointMasses& m = body.masses;
  return m.bodies[i]->getWorldTransform().getOrigin() != m.leftPosition[i] ||
         m.bodies[i]->getLinearVelocity() != m.leftVelocity[i];
}

bool anyPointMoves(const SoftBodyData& body, btScalar tick) {
  if (body.masses.changed) return true;
  for (std::uint32_t i = 0; i < body.masses.bodies.size(); ++i) {
    const double displacement = (body.state.position.col(i) - body.masses.startPosition.col(i)).norm();
    if (isChangedOutside(body, i) ||
        displacement >= double(body.masses.bodies[i]->getLinearSleepingThreshold() * tick))
      return true;
  }
  return false;
}

Eigen::Vector3d currentPosition(const SoftBodyData& body, std::uint32_t i) {
  const PointMass* point = isReadable(body.masses) ? body.masses.bodies[i] : nullptr;
  // the body of a pin is where the pin goes in the next tick
  if (!point || (body.masses.held[i] && point->isKinematicObject())) return body.state.position.col(i);
  return body.state.position.col(i) +
         difference(point->getWorldTransform().getOrigin(), body.masses.leftPosition[i]);
}

Eigen::Vector3d positionAt(const SoftBodyData& body, std::uint32_t i, double tickFraction) {
  // the last tick of a body that sleeps or is no longer stepped is long past
  if (body.asleep || !body.alive) return currentPosition(body, i);
  const Eigen::Vector3d now = body.state.position.col(i);
  const Eigen::Vector3d end = body.masses.held[i] ? now : currentPosition(body, i);
  return end + (tickFraction - 1.0) * (now - body.masses.startPosition.col(i));
}

Eigen::Vector3d currentVelocity(const SoftBodyData& body, std::uint32_t i) {
  const PointMass* point = isReadable(body.masses) ? body.masses.bodies[i] : nullptr;
  if (!point || body.masses.held[i]) return body.state.velocity.col(i);
  return body.state.velocity.col(i) + difference(point->getLinearVelocity(), body.masses.leftVelocity[i]);
}

void setPinned(SoftBodyData& body, std::uint32_t i, bool pinned) {
  PointMass* point = body.masses.bodies[i];
  if (!point) return;
  const int kinematic = btCollisionObject::CF_KINEMATIC_OBJECT;
  // keeps a mass that the user has set, even while pinned; restores the mass of the settings exactly
  const btScalar original = settingsMassOf(body, i);
  const btScalar present = point->getInvMass() == btScalar(1) / original ? original : point->getMass();
  if (pinned) point->massBeforePin = present;
  const btScalar mass = present > btScalar(0) ? present : point->massBeforePin;
  // setMassProps(0) makes the body static, but a kinematic body may also be moved
  point->setMassProps(pinned ? btScalar(0) : mass, btVector3(0, 0, 0));
  const int flags = point->getCollisionFlags() & ~(kinematic | btCollisionObject::CF_STATIC_OBJECT);
  point->setCollisionFlags(pinned ? flags | kinematic : flags);
  body.state.velocity.col(i) = pinned ? Eigen::Vector3d::Zero() : Eigen::Vector3d(body.state.velocity.col(i));
  point->setLinearVelocity(toBullet(body.state.velocity.col(i)));
  body.masses.held[i] = pinned;
  if (!pinned) body.surface.freed = true;
  body.masses.placed = true;
  remember(body.masses, i);
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
