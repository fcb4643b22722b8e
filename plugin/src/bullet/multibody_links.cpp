// SPDX-License-Identifier: Zlib

// This file makes rigid bodies and joints from the links of multibodies for a tick, and applies the resulting
// impulses and motions to the multibodies.

#include "bullet/soft_body_data.h"
#include "bullet/tick_contacts.h"

#include <BulletDynamics/Featherstone/btMultiBodyJointLimitConstraint.h>
#include <BulletDynamics/Featherstone/btMultiBodyJointMotor.h>

#include <Eigen/LU>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {
namespace {

using Eigen::Vector3d;
using Vector6d = Eigen::Matrix<double, 6, 1>;
/// One column per degree of freedom of a joint.
using Freedom = Eigen::Matrix<double, 6, Eigen::Dynamic, Eigen::ColMajor, 6, 6>;

/// Number of ticks after which a body that has no soft body near it is removed.
constexpr int kMaxUnusedTicks = 120;

btTransform poseOf(const btMultiBody& m, int link) {
  if (link < 0) return btTransform(m.getWorldToBaseRot().inverse(), m.getBasePos());
  return btTransform(m.localFrameToWorld(link, btMatrix3x3::getIdentity()),
                     m.localPosToWorld(link, btVector3(0, 0, 0)));
}

/// Sets the pose and velocity of a link from the multibody's own state, because its collider is updated only
/// after each tick.
void placeLink(LinkBody& body, const btVector3& velocity, const btVector3& spin) {
  const btMultiBody& m = *body.multiBody;
  const bool isBase = body.link < 0;
  const btTransform pose = poseOf(m, body.link);
  body.setMassProps(isBase ? m.getBaseMass() : m.getLinkMass(body.link),
                    isBase ? m.getBaseInertia() : m.getLinkInertia(body.link));
  body.setWorldTransform(pose);
  body.setInterpolationWorldTransform(pose);
  body.updateInertiaTensor();
  body.setLinearVelocity(pose.getBasis() * velocity);
  body.setAngularVelocity(pose.getBasis() * spin);
  body.clearForces();
  // the force includes gravity
  body.applyCentralForce(isBase ? m.getBaseForce() : m.getLinkForce(body.link));
  body.applyTorque(isBase ? m.getBaseTorque() : m.getLinkTorque(body.link));
  body.impulse = body.angularImpulse = btVector3(0, 0, 0);
}

/// Returns the directions in which a joint lets its link move: its angular velocity and, below, the velocity
/// of the link's centre of mass, in the link's frame.
Freedom freedomOf(const btMultibodyLink& link) {
  Freedom freedom(6, link.m_dofCount);
  for (int d = 0; d < link.m_dofCount; ++d) {
    freedom.block<3, 1>(0, d) = toEigen(link.getAxisTop(d));
    freedom.block<3, 1>(3, d) = toEigen(link.getAxisBottom(d));
  }
  return freedom;
}

/// Returns the six-vectors w_d, in the link's frame, that tell the rates of a joint's degrees of freedom from
/// the relative motion of its link:  rate_d = w_d . (angular velocity, velocity).  A unit force of degree d
/// acts on the link as the torque and force w_d.
Freedom ratesOf(const btMultibodyLink& link) {
  const Freedom freedom = freedomOf(link);
  return freedom * (freedom.transpose() * freedom).inverse();
}

/// A motion, or a torque and force, in world coordinates.
struct Twist {
  Vector3d angular = Vector3d::Zero(), linear = Vector3d::Zero();
};

Twist inWorld(const btMatrix3x3& basis, const Vector6d& own) {
  return {toEigen(basis * toBullet(own.head<3>())), toEigen(basis * toBullet(own.tail<3>()))};
}

/// Returns a row that acts along `direction` on the child, and against it on the parent, `arm` (m) from the
/// parent's centre of mass to the child's.
JointConstraint rowAlong(const Twist& direction, const Vector3d& arm) {
  JointConstraint row;
  row.angularA = direction.angular, row.linearA = direction.linear;
  row.linearB = -row.linearA;
  row.angularB = -row.angularA - arm.cross(row.linearA);
  row.armB = arm;
  return row;
}

/// Returns the number of velocities: 3 angular and 3 linear ones of the base, then those of the joints.
std::size_t sizeOf(const btMultiBody& multiBody) {
  return static_cast<std::size_t>(multiBody.getNumDofs()) + 6;
}

std::vector<btScalar> velocitiesOf(const btMultiBody& multiBody) {
  return {multiBody.getVelocityVector(), multiBody.getVelocityVector() + sizeOf(multiBody)};
}

/// Whether it is a motor or a limit of single degrees of freedom.
bool isDrive(const btMultiBodyConstraint& constraint) {
  return dynamic_cast<const btMultiBodyJointMotor*>(&constraint) ||
         dynamic_cast<const btMultiBodyJointLimitConstraint*>(&constraint);
}

/// Whether the link cannot move.
bool isHeld(const btMultiBody& m, int link) {
  for (; link >= 0; link = m.getLink(link).m_parent)
    if (m.getLink(link).m_dofCount > 0) return false;
  return m.hasFixedBase();
}

}  // namespace

bool isHeldLink(const btMultiBodyLinkCollider& collider) {
  return isHeld(*collider.m_multiBody, collider.m_link);
}

void MultiBodyLinks::begin(btDiscreteDynamicsWorld& world) {
  world_ = dynamic_cast<btMultiBodyDynamicsWorld*>(&world);
  objects_ = world.getNumCollisionObjects();
  touched_.clear();
  drives_.clear();
  lastSupported_.swap(supported_);
  supported_.clear();
  const auto isOld = [](const auto& body) { return ++body->unused > kMaxUnusedTicks; };
  bodies_.erase(std::remove_if(bodies_.begin(), bodies_.end(), isOld), bodies_.end());
}

LinkBody& MultiBodyLinks::bodyOf(btMultiBody& multiBody, int link) {
  const auto isThis = [&](const auto& b) { return b->multiBody == &multiBody && b->link == link; };
  auto it = std::find_if(bodies_.begin(), bodies_.end(), isThis);
  if (it == bodies_.end()) it = bodies_.insert(it, std::make_unique<LinkBody>(multiBody, link));
  LinkBody& body = **it;
  if (body.unused == 0) return body;
  body.unused = 0;
  body.collider = nullptr;
  body.setCollisionShape(&none_);
  // after all objects of the world
  body.setWorldArrayIndex(objects_ + static_cast<int>(it - bodies_.begin()));
  findLinkVelocities(multiBody);
  placeLink(body, velocities_[link + 1], spins_[link + 1]);
  return body;
}

LinkBody& MultiBodyLinks::bodyOf(const btMultiBodyLinkCollider& collider) {
  LinkBody& body = bodyOf(*collider.m_multiBody, collider.m_link);
  if (body.collider == &collider) return body;
  body.collider = &collider;
  auto& object = const_cast<btMultiBodyLinkCollider&>(collider);
  body.setCollisionShape(object.getCollisionShape());
  body.setBroadphaseHandle(object.getBroadphaseHandle());
  body.setWorldArrayIndex(object.getWorldArrayIndex());
  body.setFriction(object.getFriction());
  body.setRestitution(object.getRestitution());
  body.forceActivationState(object.getActivationState());
  return body;
}

/// The joint between a link and its parent, as rigid bodies.
struct MultiBodyLinks::Joint {
  const btMultibodyLink& link;
  LinkBody &child, &parent;

  const btMatrix3x3& basis() const { return child.getWorldTransform().getBasis(); }
  /// m, from the parent's centre of mass to the child's.
  Vector3d arm() const {
    return toEigen(child.getCenterOfMassPosition()) - toEigen(parent.getCenterOfMassPosition());
  }
};

MultiBodyLinks::Joint MultiBodyLinks::jointOf(btMultiBody& multiBody, int link) {
  const btMultibodyLink& joint = multiBody.getLink(link);
  return {joint, bodyOf(multiBody, link), bodyOf(multiBody, joint.m_parent)};
}

bool MultiBodyLinks::findSides(const Joint& joint, TickContacts& found, JointConstraint& row) {
  const auto numberOf = [&](LinkBody& body) {
    const bool fixed = body.link < 0 && body.multiBody->hasFixedBase();
    return fixed || !isFree(body) ? JointConstraint::kHeld : found.add(body);
  };
  row.a = numberOf(joint.child);
  row.b = numberOf(joint.parent);
  return row.a != JointConstraint::kHeld || row.b != JointConstraint::kHeld;
}

void MultiBodyLinks::addJoint(const Joint& joint, TickContacts& found) {
  JointConstraint sides;
  if (!findSides(joint, found, sides)) return;
  // all directions except those of the joint's freedom
  const Freedom freedom = freedomOf(joint.link);
  const Eigen::Matrix<double, 6, 6> directions = orthogonalColumns(freedom, 6);
  for (Eigen::Index d = freedom.cols(); d < 6; ++d) {
    JointConstraint row = rowAlong(inWorld(joint.basis(), directions.col(d)), joint.arm());
    row.a = sides.a, row.b = sides.b;
    found.joints.push_back(row);
    found.jointSources.emplace_back();
  }
  addTorques(joint);
}

void MultiBodyLinks::addTorques(const Joint& joint) {
  const int count = joint.link.m_dofCount;
  if (count == 0) return;
  Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, 6, 1> torques(count);
  for (int d = 0; d < count; ++d) torques[d] = double(joint.link.m_jointTorque[d]);
  const Twist w = inWorld(joint.basis(), ratesOf(joint.link) * torques);
  joint.child.applyTorque(toBullet(w.angular));
  joint.child.applyCentralForce(toBullet(w.linear));
  joint.parent.applyTorque(toBullet(-w.angular - joint.arm().cross(w.linear)));
  joint.parent.applyCentralForce(toBullet(-w.linear));
}

void MultiBodyLinks::addJoints(btMultiBody& multiBody, btCollisionObject& touched, TickContacts& found) {
  for (int link = -1; link < multiBody.getNumLinks(); ++link) {
    LinkBody& body = bodyOf(multiBody, link);
    if (body.collider) continue;
    body.setBroadphaseHandle(touched.getBroadphaseHandle());
    body.forceActivationState(touched.getActivationState());
  }
  for (int link = 0; link < multiBody.getNumLinks(); ++link) addJoint(jointOf(multiBody, link), found);
  if (!world_) return;
  const bool alone = isAlone(multiBody);
  if (!alone) supported_.push_back({&multiBody, forcesOn(multiBody), {}, {}});
  const auto isThis = [&](const Supported& last) { return last.multiBody == &multiBody; };
  const auto last = std::find_if(lastSupported_.begin(), lastSupported_.end(), isThis);
  if (!alone && last != lastSupported_.end() && last->change.size() == sizeOf(multiBody))
    repeatForces(*last, found.tick);  // those of drives, too
  else
    addDrives(multiBody, found);
}

/// Returns the forces (N) and torques (N m) on its links.
std::vector<btVector3> MultiBodyLinks::forcesOn(btMultiBody& multiBody) {
  std::vector<btVector3> forces;
  for (int link = -1; link < multiBody.getNumLinks(); ++link) {
    const LinkBody& body = bodyOf(multiBody, link);
    forces.push_back(body.getTotalForce());
    forces.push_back(body.getTotalTorque());
  }
  return forces;
}

/// Adds what Bullet's solver added to the forces of the last tick. Otherwise a robot would fall in the step,
/// and what lies on it, until the solver stops its feet.
void MultiBodyLinks::repeatForces(const Supported& last, double tick) {
  btMultiBody& multiBody = *last.multiBody;
  const Numbers present = velocitiesOf(multiBody);
  // for a moment its velocities are their change in the last tick
  multiBody.applyDeltaVeeMultiDof(present.data(), btScalar(-1));
  multiBody.applyDeltaVeeMultiDof(last.change.data(), btScalar(1));
  findLinkVelocities(multiBody);
  multiBody.applyDeltaVeeMultiDof(velocitiesOf(multiBody).data(), btScalar(-1));
  multiBody.applyDeltaVeeMultiDof(present.data(), btScalar(1));
  const auto perTick = static_cast<btScalar>(1.0 / tick);
  const btVector3* before = last.forces.data();
  for (int link = -1; link < multiBody.getNumLinks(); ++link) {
    LinkBody& body = bodyOf(multiBody, link);
    const btMatrix3x3& basis = body.getWorldTransform().getBasis();
    const bool isBase = link < 0;
    const btScalar mass = isBase ? multiBody.getBaseMass() : multiBody.getLinkMass(link);
    const btVector3& inertia = isBase ? multiBody.getBaseInertia() : multiBody.getLinkInertia(link);
    body.applyCentralForce(basis * velocities_[link + 1] * (mass * perTick) - *before++);
    body.applyTorque(basis * (inertia * spins_[link + 1]) * perTick - *before++);
  }
}

/// Adds what forces change of the velocities in a time (s), and computes the inertias for what follows.
void MultiBodyLinks::accelerate(btMultiBody& multiBody, btScalar time) {
  multiBody.computeAccelerationsArticulatedBodyAlgorithmMultiDof(time, numbers_, vectors_, matrices_, false,
                                                                 false, false);
}

/// Sets velocities_ and spins_ to those of the links, the base first, in their own axes.
void MultiBodyLinks::findLinkVelocities(btMultiBody& multiBody) {
  spins_.resize(multiBody.getNumLinks() + 1);
  velocities_.resize(multiBody.getNumLinks() + 1);
  multiBody.compTreeLinkVelocities(&spins_[0], &velocities_[0]);
}

/// Adds the rows of its motors and limits.
void MultiBodyLinks::addDrives(btMultiBody& multiBody, TickContacts& found) {
  accelerate(multiBody, btScalar(0));
  for (int i = 0; i < world_->getNumMultiBodyConstraints(); ++i) {
    btMultiBodyConstraint& drive = *world_->getMultiBodyConstraint(i);
    if (drive.getMultiBodyA() != &multiBody && drive.getMultiBodyB() != &multiBody) continue;
    if (isDrive(drive)) addDrive(multiBody, drive, found);
  }
}

/// Adds the rows that Bullet's solver would make: J . (change of the velocities) = m_rhs / m_jacDiagABInv.
void MultiBodyLinks::addDrive(btMultiBody& multiBody, btMultiBodyConstraint& drive, TickContacts& found) {
  btContactSolverInfo info = world_->getSolverInfo();
  info.m_timeStep = static_cast<btScalar>(found.tick);
  btMultiBodyConstraintArray rows;
  btMultiBodyJacobianData data;
  data.m_solverBodyPool = nullptr, data.m_fixedBodyId = 0;
  const int companion = multiBody.getCompanionId();
  multiBody.setCompanionId(-1);
  drive.createConstraintRows(rows, data, info);
  multiBody.setCompanionId(companion);
  for (int i = 0; i < rows.size(); ++i) {
    const btMultiBodySolverConstraint& row = rows[i];
    if (row.m_jacDiagABInv > btScalar(0))
      addDriveRows(multiBody, row, &data.m_jacobians[row.m_jacAindex], found);
  }
  if (dynamic_cast<btMultiBodyJointLimitConstraint*>(&drive)) addComingLimits(multiBody, drive, found);
}

void MultiBodyLinks::addDriveRows(btMultiBody& multiBody, const btMultiBodySolverConstraint& source,
                                  const btScalar* jacobian, TickContacts& found) {
  for (int link = 0; link < multiBody.getNumLinks(); ++link) {
    const btMultibodyLink& joint = multiBody.getLink(link);
    for (int d = 0; d < joint.m_dofCount; ++d) {
      const int column = 6 + joint.m_dofOffset + d;
      const double share = double(jacobian[column]);
      if (share == 0.0) continue;
      JointConstraint row;
      row.speed = share * double(multiBody.getVelocityVector()[column]) +
                  double(source.m_rhs / source.m_jacDiagABInv);
      if (source.m_lowerLimit > -SIMD_INFINITY) row.lower = double(source.m_lowerLimit);
      if (source.m_upperLimit < SIMD_INFINITY) row.upper = double(source.m_upperLimit);
      addDriveRow(multiBody, {source.m_orgConstraint, column, share, 0}, link, d, row, found);
    }
  }
}

/// Adds limits that may be reached in the tick: Bullet makes rows of those that are reached. A joint that
/// rests on its limit would be free for a tick whenever rounding lifts it off.
void MultiBodyLinks::addComingLimits(btMultiBody& multiBody, btMultiBodyConstraint& limit,
                                     TickContacts& found) {
  constexpr double kFast = 1e3;  // 1/s^2 or m/s^2, an acceleration that few joints exceed
  const int link = limit.getLinkA(), column = 6 + multiBody.getLink(link).m_dofOffset;
  for (int side = 0; side < limit.getNumRows(); ++side) {
    const double share = side == 0 ? 1.0 : -1.0, distance = double(limit.getPosition(side));
    const double approach = -share * double(multiBody.getVelocityVector()[column]);
    if (!(distance > 0.0) || distance > found.tick * (approach + found.tick * kFast)) continue;
    JointConstraint row;
    row.speed = -distance / found.tick;
    row.lower = 0.0;
    addDriveRow(multiBody, {&limit, column, share, 0}, link, 0, row, found);
  }
}

/// Adds the row, of which speed and limits are set.
void MultiBodyLinks::addDriveRow(btMultiBody& multiBody, Drive drive, int link, int degree,
                                 const JointConstraint& limits, TickContacts& found) {
  const Joint joint = jointOf(multiBody, link);
  JointConstraint row =
      rowAlong(inWorld(joint.basis(), drive.share * ratesOf(joint.link).col(degree)), joint.arm());
  if (!findSides(joint, found, row)) return;
  row.speed = limits.speed, row.lower = limits.lower, row.upper = limits.upper;
  row.isDriven = row.lower > -HUGE_VAL && row.upper < HUGE_VAL;
  drive.row = found.joints.size();
  drives_.push_back(drive);
  found.joints.push_back(row);
  found.jointSources.emplace_back();
}

void MultiBodyLinks::addJoints(TickContacts& found) {
  const std::size_t count = found.rigids.size();
  for (std::size_t i = 0; i < count; ++i) {
    const LinkBody* body = LinkBody::from(found.rigids[i].body);
    if (!body || std::find(touched_.begin(), touched_.end(), body->multiBody) != touched_.end()) continue;
    touched_.push_back(body->multiBody);
    addJoints(*body->multiBody, *found.rigids[i].body, found);
  }
}

// --- after the step ----------------------------------------------------------------------------------------

void MultiBodyLinks::applyImpulses(const TickContacts& found) {
  if (touched_.empty()) return;
  for (const Contact& c : found.contacts)
    for (const ContactPoint* point : {&c.a, &c.b}) {
      if (point->kind != ContactPoint::Kind::Rigid) continue;
      LinkBody* body = LinkBody::from(found.rigids[point->body].body);
      if (!body) continue;
      const Vector3d impulse = (point == &c.a ? 1.0 : -1.0) / point->massFactor * c.impulse.sum;
      body->impulse += toBullet(impulse);
      body->angularImpulse += toBullet(point->arm.cross(impulse));
    }
  for (btMultiBody* multiBody : touched_) apply(*multiBody, found);
}

/// Sets force_ to the impulses of the contacts in the directions of the degrees of freedom. Returns false if
/// there are none.
bool MultiBodyLinks::collectImpulses(btMultiBody& multiBody) {
  force_.assign(sizeOf(multiBody), btScalar(0));
  std::vector<btScalar> jacobian(force_.size());
  bool any = false;
  for (const auto& body : bodies_) {
    if (body->multiBody != &multiBody || body->unused > 0) continue;
    if (body->impulse.isZero() && body->angularImpulse.isZero()) continue;
    any = true;
    multiBody.fillConstraintJacobianMultiDof(body->link, poseOf(multiBody, body->link).getOrigin(),
                                             body->angularImpulse, body->impulse, jacobian.data(), numbers_,
                                             vectors_, matrices_);
    for (std::size_t i = 0; i < force_.size(); ++i) force_[i] += jacobian[i];
  }
  return any;
}

/// Returns the change of the velocities by the impulses in force_.
MultiBodyLinks::Numbers MultiBodyLinks::changeByImpulses(btMultiBody& multiBody) {
  Numbers change(force_.size());
  accelerate(multiBody, btScalar(0));
  multiBody.calcAccelerationDeltasMultiDof(force_.data(), change.data(), numbers_, vectors_);
  return change;
}

void MultiBodyLinks::apply(btMultiBody& multiBody, const TickContacts& found) {
  const bool any = collectImpulses(multiBody);
  const auto isThis = [&](const Supported& supported) { return supported.multiBody == &multiBody; };
  const auto supported = std::find_if(supported_.begin(), supported_.end(), isThis);
  const bool alone = world_ && supported == supported_.end();
  if (any && alone) applyMotion(multiBody, found);
  if (any && !alone) multiBody.applyDeltaVeeMultiDof(changeByImpulses(multiBody).data(), btScalar(1));
  if (supported != supported_.end()) supported->start = velocitiesOf(multiBody);
}

/// Gives the multibody the motion of the step, as writeRigidToBullet() does for rigid bodies: the mean
/// velocities of the tick, from which Bullet integrates the positions after it has added that of forces. The
/// rest is added by finishMotions().
void MultiBodyLinks::applyMotion(btMultiBody& multiBody, const TickContacts& found) {
  for (const Drive& drive : drives_)
    if (drive.constraint->getMultiBodyA() == &multiBody)
      force_[static_cast<std::size_t>(drive.column)] +=
          static_cast<btScalar>(drive.share * found.joints[drive.row].impulse);
  const Numbers change = changeByImpulses(multiBody), mean = meanVelocities(multiBody, found),
                before = velocitiesOf(multiBody);
  accelerate(multiBody, static_cast<btScalar>(found.tick));
  const Numbers byForces = velocitiesOf(multiBody);
  Motion motion{&multiBody, static_cast<btScalar>(found.tick), Numbers(change.size()),
                Numbers(change.size())};
  Numbers start(change.size());
  for (std::size_t i = 0; i < change.size(); ++i) {
    start[i] = before[i] + mean[i] - 2 * byForces[i];
    motion.rest[i] = byForces[i] + change[i] - mean[i];
    motion.byForces[i] = byForces[i] - before[i];
  }
  multiBody.applyDeltaVeeMultiDof(start.data(), btScalar(1));
  motions_.push_back(std::move(motion));
  disableMotors(multiBody, found);
}

/// Returns the velocities with which Bullet's integration moves the links to where they are after the step.
MultiBodyLinks::Numbers MultiBodyLinks::meanVelocities(btMultiBody& multiBody, const TickContacts& found) {
  const auto motionOf = [&](const LinkBody& body) -> Twist {
    const std::uint32_t number = found.find(body);
    if (number == TickContacts::kNone || found.rigids[number].held) return {};
    const RigidPartner& partner = found.rigids[number];
    return {partner.turn / found.tick + partner.spinOffset, toEigen(partner.expectedVelocity)};
  };
  Numbers mean(sizeOf(multiBody), btScalar(0));
  const Twist base = motionOf(bodyOf(multiBody, -1));
  for (int i = 0; i < 3; ++i) {
    mean[static_cast<std::size_t>(i)] = static_cast<btScalar>(base.angular[i]);
    mean[static_cast<std::size_t>(3 + i)] = static_cast<btScalar>(base.linear[i]);
  }
  for (int link = 0; link < multiBody.getNumLinks(); ++link) {
    const int count = multiBody.getLink(link).m_dofCount;
    if (count == 0) continue;
    const Joint joint = jointOf(multiBody, link);
    const Twist own = motionOf(joint.child), carried = motionOf(joint.parent);
    const btMatrix3x3 toOwn = joint.basis().transpose();
    Vector6d relative;
    relative << toEigen(toOwn * toBullet(own.angular - carried.angular)),
        toEigen(toOwn * toBullet(own.linear - carried.linear - carried.angular.cross(joint.arm())));
    const auto rates = (ratesOf(joint.link).transpose() * relative).eval();
    for (int d = 0; d < count; ++d)
      mean[static_cast<std::size_t>(6 + joint.link.m_dofOffset + d)] = static_cast<btScalar>(rates[d]);
  }
  return mean;
}

/// Whether nothing but soft bodies, its motors and its limits act on the multibody, as far as is known.
/// Bullet's solver resolves everything else, from the velocities at the end of the tick.
bool MultiBodyLinks::isAlone(const btMultiBody& multiBody) const {
  if (!world_) return false;
  const auto isMoved = [&](const btMultiBody* m, int link) { return m == &multiBody && !isHeld(*m, link); };
  for (int i = 0; i < world_->getNumMultiBodyConstraints(); ++i) {
    btMultiBodyConstraint& c = *world_->getMultiBodyConstraint(i);
    if (isDrive(c)) continue;
    if (isMoved(c.getMultiBodyA(), c.getLinkA()) || isMoved(c.getMultiBodyB(), c.getLinkB())) return false;
  }
  const auto isMovedLink = [&](const btCollisionObject* object) {
    const btMultiBodyLinkCollider* link = btMultiBodyLinkCollider::upcast(object);
    return link && isMoved(link->m_multiBody, link->m_link);
  };
  btDispatcher& dispatcher = *world_->getDispatcher();
  for (int i = 0; i < dispatcher.getNumManifolds(); ++i) {
    const btPersistentManifold& m = *dispatcher.getManifoldByIndexInternal(i);
    if (m.getNumContacts() > 0 && (isMovedLink(m.getBody0()) || isMovedLink(m.getBody1())) &&
        !isSoft(m.getBody0()) && !isSoft(m.getBody1()))
      return false;
  }
  return true;
}

/// The step has applied their impulses.
void MultiBodyLinks::disableMotors(const btMultiBody& multiBody, const TickContacts& found) {
  for (const Drive& drive : drives_) {
    if (drive.constraint->getMultiBodyA() != &multiBody) continue;
    if (!dynamic_cast<btMultiBodyJointMotor*>(drive.constraint)) continue;
    motors_.push_back({drive.constraint, drive.constraint->getMaxAppliedImpulse(),
                       static_cast<btScalar>(found.joints[drive.row].impulse)});
    drive.constraint->setMaxAppliedImpulse(btScalar(0));
  }
}

/// Adds the rest of the velocities. Those by forces are the mean of what they are at both ends of the tick,
/// as in velocity Verlet: with those of its start alone, swinging links would gain energy.
void MultiBodyLinks::finish(const Motion& motion) {
  btMultiBody& multiBody = *motion.multiBody;
  multiBody.applyDeltaVeeMultiDof(motion.rest.data(), btScalar(1));
  const Numbers before = velocitiesOf(multiBody);
  accelerate(multiBody, motion.tick);
  const Numbers after = velocitiesOf(multiBody);
  Numbers correction(before.size());
  for (std::size_t i = 0; i < before.size(); ++i)
    correction[i] = before[i] - after[i] + btScalar(0.5) * (after[i] - before[i] - motion.byForces[i]);
  multiBody.applyDeltaVeeMultiDof(correction.data(), btScalar(1));
}

void MultiBodyLinks::finishMotions() {
  const auto isMotor = [&](const btMultiBodyConstraint* constraint) {
    for (int i = 0; i < world_->getNumMultiBodyConstraints(); ++i)
      if (world_->getMultiBodyConstraint(i) == constraint) return true;
    return false;
  };
  const auto isIn = [&](const btMultiBody* multiBody) {
    for (int i = 0; i < world_->getNumMultibodies(); ++i)
      if (world_->getMultiBody(i) == multiBody) return true;
    return false;
  };
  for (const Motor& motor : motors_) {
    if (!isMotor(motor.constraint)) continue;
    motor.constraint->setMaxAppliedImpulse(motor.maxImpulse);
    motor.constraint->internalSetAppliedImpulse(0, motor.impulse);
  }
  for (const Motion& motion : motions_)
    if (isIn(motion.multiBody)) finish(motion);
  motors_.clear();
  motions_.clear();
  for (Supported& supported : supported_) {
    if (!isIn(supported.multiBody) || supported.start.size() != sizeOf(*supported.multiBody)) continue;
    supported.change = velocitiesOf(*supported.multiBody);
    for (std::size_t i = 0; i < supported.start.size(); ++i) supported.change[i] -= supported.start[i];
    supported.start.clear();
  }
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
