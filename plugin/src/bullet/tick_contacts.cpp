// SPDX-License-Identifier: Zlib

// This file updates rigid bodies before and after Bullet's solver, numbers those in the contacts of a tick,
// and stores the contact impulses.

#include "bullet/tick_contacts.h"

#include "bullet/bullet_objects.h"
#include "bullet/kinematic_motion.h"
#include "bullet/soft_body_data.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

// --- rigid bodies in contacts ------------------------------------------------------------------------------

namespace {

void gatherHeldRigid(RigidPartner& partner, RigidState& state, btScalar tick) {
  const btRigidBody& body = *partner.body;
  const btTransform& pose =
      isKinematic(body) ? body.getInterpolationWorldTransform() : body.getWorldTransform();
  state = RigidState();
  state.position = toEigen(partner.lastPose.getOrigin());
  state.rotation = toEigen(partner.lastPose.getRotation());
  state.velocity = (toEigen(pose.getOrigin()) - state.position) / double(tick);
  state.angularVelocity = rotationBetween(state.rotation, toEigen(pose.getRotation())) / double(tick);
  partner.lastPose = pose;
}

/// Returns the change (rad/s) of the angular velocity that Bullet's solver makes for unequal moments of
/// inertia.
Eigen::Vector3d gyroscopicChange(const btRigidBody& body, btScalar tick) {
  if (body.getFlags() & BT_ENABLE_GYROSCOPIC_FORCE_IMPLICIT_WORLD)
    return toEigen(body.computeGyroscopicImpulseImplicit_World(tick));
  if (body.getFlags() & BT_ENABLE_GYROSCOPIC_FORCE_IMPLICIT_BODY)
    return toEigen(body.computeGyroscopicImpulseImplicit_Body(tick));
  return Eigen::Vector3d::Zero();
}

Eigen::Vector3d torqueAcceleration(const btRigidBody& body) {
  return toEigen(body.getInvInertiaTensorWorld() * body.getTotalTorque());
}

/// Sets the angular velocity (rad/s) at the start of the solver such that it becomes `target` before
/// impulses.
void setInitialAngularVelocity(btRigidBody& body, const Eigen::Vector3d& target, btScalar tick) {
  Eigen::Vector3d initial = target;
  for (int i = 0; i < 3; ++i) {
    body.setAngularVelocity(toBullet(initial));
    initial = target - gyroscopicChange(body, tick);
  }
  body.setAngularVelocity(toBullet(initial));
}

void gatherFreeRigid(RigidPartner& partner, RigidState& state, btScalar tick) {
  const btRigidBody& body = *partner.body;
  state.position = toEigen(body.getWorldTransform().getOrigin());
  state.rotation = toEigen(body.getWorldTransform().getRotation());
  state.velocity = toEigen(body.getLinearVelocity());
  state.angularVelocity = toEigen(body.getAngularVelocity());
  state.acceleration = toEigen(body.getTotalForce()) * double(body.getInvMass());
  state.angularAcceleration = torqueAcceleration(body) + gyroscopicChange(body, tick) / double(tick);
  state.inverseMass = toEigen(body.getLinearFactor()) * double(body.getInvMass());
  state.inverseInertiaLocal = toEigen(body.getInvInertiaDiagLocal());
  state.angularFactor = toEigen(body.getAngularFactor());
}

/// Returns the factor by which Bullet multiplies velocities in the tick, before its solver. It is 0 only if
/// damping removes all motion.
double dampingFactor(btScalar damping, btScalar tick) {
  return std::pow(1.0 - double(damping), double(tick));
}

}  // namespace

RigidPartner makePartner(btRigidBody& body) {
  RigidPartner partner;
  partner.body = &body;
  partner.handle = handleOf(body);
  partner.lastPose = body.getWorldTransform();
  return partner;
}

void gatherRigid(RigidPartner& partner, RigidState& state, btScalar tick) {
  partner.held =
      isStaticOrKinematic(*partner.body) || partner.body->getActivationState() == DISABLE_SIMULATION;
  if (partner.held)
    gatherHeldRigid(partner, state, tick);
  else
    gatherFreeRigid(partner, state, tick);
  partner.start = state;
}

void writeRigidToBullet(RigidPartner& partner, const RigidState& end, btScalar tick) {
  if (partner.held) return;
  btRigidBody& body = *partner.body;
  const double h = double(tick);
  const Eigen::Vector3d mean = (end.position - partner.start.position) / h;
  const Eigen::Vector3d meanAngular = rotationBetween(partner.start.rotation, end.rotation) / h;
  const double linear = dampingFactor(body.getLinearDamping(), tick);
  const double angular = dampingFactor(body.getAngularDamping(), tick);
  const Eigen::Vector3d initial = mean - h * partner.start.acceleration;
  setInitialAngularVelocity(body, meanAngular - h * torqueAcceleration(body), tick);
  if (linear > 0.0) body.setLinearVelocity(toBullet(initial / linear));
  if (angular > 0.0) body.setAngularVelocity(body.getAngularVelocity() / static_cast<btScalar>(angular));
  partner.expectedVelocity = toBullet(mean);
  partner.expectedAngularVelocity = toBullet(meanAngular);
}

void readRigidFromBullet(RigidPartner& partner, const RigidState& end, btScalar tick) {
  if (partner.held || !partner.body->isActive()) return;
  btRigidBody& body = *partner.body;
  const Eigen::Vector3d velocity = dampingFactor(body.getLinearDamping(), tick) * end.velocity;
  const Eigen::Vector3d spin = dampingFactor(body.getAngularDamping(), tick) * end.angularVelocity;
  body.setLinearVelocity(body.getLinearVelocity() - partner.expectedVelocity + toBullet(velocity));
  body.setAngularVelocity(body.getAngularVelocity() - partner.expectedAngularVelocity + toBullet(spin));
  body.setInterpolationLinearVelocity(body.getLinearVelocity());
  body.setInterpolationAngularVelocity(body.getAngularVelocity());
}

// --- the contacts of a tick --------------------------------------------------------------------------------

std::uint32_t TickContacts::find(const btRigidBody& body) const {
  const auto index = static_cast<std::size_t>(body.getWorldArrayIndex());
  return index < numbers_.size() ? numbers_[index] : kNone;
}

std::uint32_t TickContacts::add(btRigidBody& body) {
  if (const std::uint32_t number = find(body); number != kNone) return number;
  const auto index = static_cast<std::size_t>(body.getWorldArrayIndex());
  if (index >= numbers_.size()) numbers_.resize(index + 1, kNone);
  numbers_[index] = static_cast<std::uint32_t>(rigids.size());
  rigids.push_back(makePartner(body));
  return numbers_[index];
}

void TickContacts::add(const Contact& contact, const ContactSource& source) {
  contacts.push_back(contact);
  sources.push_back(source);
}

void TickContacts::clear(double comingTick) {
  tick = comingTick;
  for (const RigidPartner& rigid : rigids) numbers_[static_cast<std::size_t>(rigid.handle.index)] = kNone;
  rigids.clear();
  contacts.clear();
  sources.clear();
  candidates.clear();
  joints.clear();
  jointSources.clear();
}

Eigen::Vector3d velocityOf(const btCollisionObject& object, const btVector3& position, double tick) {
  if (isKinematic(object)) return kinematicDisplacement(object, toEigen(position)) / tick;
  const btRigidBody* rigid = btRigidBody::upcast(&object);
  if (!rigid || rigid->isStaticObject() || !rigid->isActive()) return Eigen::Vector3d::Zero();
  return toEigen(rigid->getVelocityInLocalPoint(position - rigid->getWorldTransform().getOrigin()));
}

ContactPoint rigidContactPoint(TickContacts& contacts, const btCollisionObject& object,
                               const btVector3& position) {
  ContactPoint found;
  btRigidBody* rigid = btRigidBody::upcast(const_cast<btCollisionObject*>(&object));
  if (rigid && isFree(*rigid)) {
    found.kind = ContactPoint::Kind::Rigid;
    found.body = contacts.add(*rigid);
    found.arm = toEigen(position) - toEigen(rigid->getWorldTransform().getOrigin());
  } else {
    found.velocity = velocityOf(object, position, contacts.tick);
  }
  return found;
}

// --- impulses of the last tick -----------------------------------------------------------------------------

namespace {

using Id = std::pair<int, std::uint64_t>;

Id idOf(const StoredImpulse& stored) { return {stored.partner, stored.key}; }

Id idOf(const ContactSource& source) { return {source.partner.id, source.key}; }

}  // namespace

void warmStart(TickContacts& contacts) {
  for (std::size_t i = 0; i < contacts.contacts.size(); ++i) {
    const ContactSource& source = contacts.sources[i];
    if (!source.body) continue;
    const Id id = idOf(source);
    const std::vector<StoredImpulse>& stored = source.body->storedImpulses;
    const auto it = std::lower_bound(stored.begin(), stored.end(), id,
                                     [](const StoredImpulse& k, const Id& other) { return idOf(k) < other; });
    if (it != stored.end() && idOf(*it) == id && it->object == source.partner.object)
      contacts.contacts[i].positionImpulse = it->impulse;
  }
}

void storeImpulses(const std::vector<SoftBodyData*>& bodies, const TickContacts& contacts) {
  for (SoftBodyData* body : bodies) body->storedImpulses.clear();
  for (std::size_t i = 0; i < contacts.contacts.size(); ++i) {
    const ContactSource& source = contacts.sources[i];
    if (!source.body) continue;
    const Contact& c = contacts.contacts[i];
    // relative to the normal at the start of the tick, as the next tick's search finds it: the direction of
    // the impulse may have changed
    const double along = c.normal.dot(c.impulse.sum);
    const Id id = idOf(source);
    source.body->storedImpulses.push_back(
        {id.first, source.partner.object, id.second, {along, c.impulse.sum - along * c.normal}});
  }
  const auto before = [](const StoredImpulse& k, const StoredImpulse& l) { return idOf(k) < idOf(l); };
  for (SoftBodyData* body : bodies)
    std::sort(body->storedImpulses.begin(), body->storedImpulses.end(), before);
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
