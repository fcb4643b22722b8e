// SPDX-License-Identifier: Zlib

// This file makes rows of Bullet's constraints and of rolling friction, and tells Bullet what they have
// borne.

#include "bullet/bullet_objects.h"
#include "bullet/surface_body.h"
#include "bullet/tick_contacts.h"

#include <cmath>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {
namespace {

using Eigen::Vector3d;

/// Bullet's largest kind of constraint has six rows and a spring or motor for each.
constexpr int kMaxRows = 16;

/// Where Bullet's constraints write their rows.
struct RowBuffer {
  btScalar linearA[4 * kMaxRows] = {}, angularA[4 * kMaxRows] = {};
  btScalar linearB[4 * kMaxRows] = {}, angularB[4 * kMaxRows] = {};
  btScalar error[4 * kMaxRows] = {}, softness[4 * kMaxRows] = {};
  btScalar lower[4 * kMaxRows], upper[4 * kMaxRows];
};

Vector3d vectorAt(const btScalar* numbers, int row) {
  return {double(numbers[4 * row]), double(numbers[4 * row + 1]), double(numbers[4 * row + 2])};
}

btTypedConstraint::btConstraintInfo2 infoOn(RowBuffer& buffer, const btContactSolverInfo& solver,
                                            btScalar tick) {
  for (int i = 0; i < 4 * kMaxRows; ++i) {
    buffer.lower[i] = -SIMD_INFINITY, buffer.upper[i] = SIMD_INFINITY;
    buffer.softness[i] = solver.m_globalCfm;
  }
  btTypedConstraint::btConstraintInfo2 info;
  info.fps = btScalar(1) / tick;
  info.erp = solver.m_erp;
  info.m_J1linearAxis = buffer.linearA, info.m_J1angularAxis = buffer.angularA;
  info.m_J2linearAxis = buffer.linearB, info.m_J2angularAxis = buffer.angularB;
  info.rowskip = 4;
  info.m_constraintError = buffer.error;
  info.cfm = buffer.softness;
  info.m_lowerLimit = buffer.lower, info.m_upperLimit = buffer.upper;
  info.m_numIterations = solver.m_numIterations;
  info.m_damping = solver.m_damping;
  return info;
}

/// The number of a side's body. What a held one's motion adds to the row's speed moves to its other side.
std::uint32_t sideOf(const btRigidBody& body, const Vector3d& linear, const Vector3d& angular,
                     const TickContacts& found, double& speed) {
  if (isFree(body)) return found.find(body);
  if (isKinematic(body)) {
    const btTransform &start = body.getWorldTransform(), &end = body.getInterpolationWorldTransform();
    const Vector3d moved = toEigen(btVector3(end.getOrigin() - start.getOrigin()));
    const Vector3d turned = rotationBetween(toEigen(start.getRotation()), toEigen(end.getRotation()));
    speed -= (linear.dot(moved) + angular.dot(turned)) / found.tick;
  }
  return JointConstraint::kHeld;
}

bool drives(const RowBuffer& buffer, int row) {
  return buffer.lower[4 * row] > -SIMD_INFINITY && buffer.upper[4 * row] < SIMD_INFINITY;
}

void addRow(const btTypedConstraint& joint, const RowBuffer& buffer, int row, btScalar tick,
            TickContacts& found) {
  JointConstraint j;
  j.linearA = vectorAt(buffer.linearA, row), j.angularA = vectorAt(buffer.angularA, row);
  j.linearB = vectorAt(buffer.linearB, row), j.angularB = vectorAt(buffer.angularB, row);
  j.lower = double(buffer.lower[4 * row]);
  j.upper = double(buffer.upper[4 * row]);
  j.speed = double(buffer.error[4 * row]);
  j.softness = double(buffer.softness[4 * row] / tick);
  j.a = sideOf(joint.getRigidBodyA(), j.linearA, j.angularA, found, j.speed);
  j.b = sideOf(joint.getRigidBodyB(), j.linearB, j.angularB, found, j.speed);
  found.joints.push_back(j);
}

/// Against turning of the sides of the last contact against each other, by `rolling` (m) times what it bears.
void addTurnRow(const btPersistentManifold& manifold, const Vector3d& axis, double rolling,
                TickContacts& found) {
  JointConstraint j;
  j.contact = static_cast<std::uint32_t>(found.contacts.size() - 1);
  j.rolling = rolling;
  j.linearA = j.linearB = Vector3d::Zero();
  j.angularA = axis, j.angularB = -axis;
  const auto side = [&](const btCollisionObject* object, const Vector3d& angular) {
    const btRigidBody* body = btRigidBody::upcast(object);
    return body ? sideOf(*body, Vector3d::Zero(), angular, found, j.speed) : JointConstraint::kHeld;
  };
  j.a = side(manifold.getBody0(), j.angularA);
  j.b = side(manifold.getBody1(), j.angularB);
  found.joints.push_back(j);
  found.jointSources.emplace_back();
}

bool isNumbered(const TickContacts& found, const btRigidBody& body) {
  return isFree(body) && found.find(body) != TickContacts::kNone;
}

/// Fills the buffer as Bullet's solver does. The number of rows; 0 too if there are too many.
int readRows(btTypedConstraint& joint, const btContactSolverInfo& solver, btScalar tick, RowBuffer& buffer) {
  joint.buildJacobian();
  btTypedConstraint::btConstraintInfo1 size;
  joint.getInfo1(&size);
  if (size.m_numConstraintRows <= 0 || size.m_numConstraintRows > kMaxRows) return 0;
  btTypedConstraint::btConstraintInfo2 info = infoOn(buffer, solver, tick);
  joint.getInfo2(&info);
  return size.m_numConstraintRows;
}

/// Puts both bodies of a joint, while it lives, to where its errors count: what moves as told to the end of
/// the tick, where Bullet's solver sees it; what moves by itself to where its velocity takes it in some time
/// (s).
class Ahead {
 public:
  Ahead(btTypedConstraint& joint, btScalar time)
      : bodies_{&joint.getRigidBodyA(), &joint.getRigidBodyB()},
        poses_{bodies_[0]->getWorldTransform(), bodies_[1]->getWorldTransform()} {
    for (btRigidBody* body : bodies_) {
      btTransform ahead = body->getWorldTransform();
      if (isKinematic(*body))
        ahead = body->getInterpolationWorldTransform();
      else if (isFree(*body) && time > btScalar(0))
        body->predictIntegratedTransform(time, ahead);
      body->setWorldTransform(ahead);
    }
  }
  ~Ahead() {
    for (int i : {0, 1}) bodies_[i]->setWorldTransform(poses_[i]);
  }
  Ahead(const Ahead&) = delete;
  Ahead& operator=(const Ahead&) = delete;

 private:
  btRigidBody* bodies_[2];
  btTransform poses_[2];
};

bool hasSprings(const btTypedConstraint& joint) {
  const btTypedConstraintType type = joint.getConstraintType();
  return type == D6_SPRING_CONSTRAINT_TYPE || type == D6_SPRING_2_CONSTRAINT_TYPE;
}

/// Springs push with the force of half a tick later. Theirs is constant in the tick of length h: at the
/// start's distance x it changes (x, v) by a matrix whose determinant is 1 + (omega h)^2 / 2, and swings
/// grow; at that of the middle, x + h v / 2, by one of determinant 1.
void takeSprings(const RowBuffer& middle, int rows, RowBuffer& buffer) {
  for (int row = 0; row < rows; ++row) {
    if (!drives(buffer, row) || !drives(middle, row)) continue;
    buffer.error[4 * row] = middle.error[4 * row];
    buffer.lower[4 * row] = middle.lower[4 * row];
    buffer.upper[4 * row] = middle.upper[4 * row];
  }
}

void addRows(btTypedConstraint& joint, const btContactSolverInfo& solver, btScalar tick,
             TickContacts& found) {
  RowBuffer buffer, middle;
  int rows = 0, inTheMiddle = 0;
  if (hasSprings(joint)) {
    const Ahead ahead(joint, tick / 2);
    inTheMiddle = readRows(joint, solver, tick, middle);
  }
  {
    const Ahead ahead(joint, 0);
    rows = readRows(joint, solver, tick, buffer);
  }
  if (inTheMiddle == rows) takeSprings(middle, rows, buffer);
  for (int row = 0; row < rows; ++row) {
    const bool is = drives(buffer, row);
    found.jointSources.push_back({&joint, is ? 0.0 : double(buffer.error[4 * row]), is});
    addRow(joint, buffer, row, tick, found);
  }
}

// --- motors and springs while Bullet's solver runs ---------------------------------------------------------

/// Calls visit(flag) for all flags of a kind of joint that let a motor or a spring push.
template <class Visit>
void forEachDrive(btGeneric6DofConstraint& joint, Visit visit) {
  for (int i = 0; i < 3; ++i) {
    visit(joint.getTranslationalLimitMotor()->m_enableMotor[i]);
    visit(joint.getRotationalLimitMotor(i)->m_enableMotor);
  }
}

template <class Visit>
void forEachDrive(btGeneric6DofSpring2Constraint& joint, Visit visit) {
  for (int i = 0; i < 3; ++i) {
    btTranslationalLimitMotor2& linear = *joint.getTranslationalLimitMotor();
    btRotationalLimitMotor2& angular = *joint.getRotationalLimitMotor(i);
    for (bool* flag : {&linear.m_enableMotor[i], &linear.m_enableSpring[i], &angular.m_enableMotor,
                       &angular.m_enableSpring})
      visit(*flag);
  }
}

/// Those of Bullet's own kinds, by getters and setters where there are no flags to be had.
template <class Visit>
void visitDrives(btTypedConstraint& joint, Visit visit) {
  const auto through = [&](bool value, auto set) {
    const bool before = value;
    visit(value);
    if (value != before) set(value);
  };
  switch (joint.getConstraintType()) {
    case HINGE_CONSTRAINT_TYPE: {
      auto& hinge = static_cast<btHingeConstraint&>(joint);
      return through(hinge.getEnableAngularMotor(), [&](bool on) { hinge.enableMotor(on); });
    }
    case CONETWIST_CONSTRAINT_TYPE: {
      auto& cone = static_cast<btConeTwistConstraint&>(joint);
      return through(cone.isMotorEnabled(), [&](bool on) { cone.enableMotor(on); });
    }
    case SLIDER_CONSTRAINT_TYPE: {
      auto& slider = static_cast<btSliderConstraint&>(joint);
      through(slider.getPoweredLinMotor(), [&](bool on) { slider.setPoweredLinMotor(on); });
      return through(slider.getPoweredAngMotor(), [&](bool on) { slider.setPoweredAngMotor(on); });
    }
    case D6_SPRING_CONSTRAINT_TYPE: {
      auto& spring = static_cast<btGeneric6DofSpringConstraint&>(joint);
      // a spring pushes through the motor of its axis, which goes on and off with it
      for (int i = 0; i < 6; ++i)
        through(spring.isSpringEnabled(i), [&](bool on) { spring.enableSpring(i, on); });
      return forEachDrive(spring, visit);
    }
    case D6_CONSTRAINT_TYPE:
      return forEachDrive(static_cast<btGeneric6DofConstraint&>(joint), visit);
    case D6_SPRING_2_CONSTRAINT_TYPE:
      return forEachDrive(static_cast<btGeneric6DofSpring2Constraint&>(joint), visit);
    default:
      return;
  }
}

/// Which ones were on, a bit each.
std::uint32_t switchOff(btTypedConstraint& joint) {
  std::uint32_t on = 0, bit = 1;
  visitDrives(joint, [&](bool& flag) {
    if (flag) on |= bit;
    bit <<= 1;
    flag = false;
  });
  return on;
}

void switchOn(btTypedConstraint& joint, std::uint32_t on) {
  visitDrives(joint, [&](bool& flag) {
    if (on & 1u) flag = true;
    on >>= 1;
  });
}

/// Whether the joint is in the world. Looks from `place` in the world's list on, and leaves there where it
/// is: rows come in the order of their joints.
bool isValid(btDynamicsWorld& world, const btTypedConstraint* joint, int& place) {
  const int count = world.getNumConstraints();
  for (int i = 0; i < count; ++i) {
    const int here = (place + i) % count;
    if (world.getConstraint(here) != joint) continue;
    place = here;
    return true;
  }
  return false;
}

void addFeedback(btJointFeedback& feedback, const JointConstraint& j, btScalar tick) {
  const auto push = [&](btVector3& sum, const Vector3d& along) {
    sum += toBullet(Vector3d(along * (j.impulse / double(tick))));
  };
  push(feedback.m_appliedForceBodyA, j.linearA);
  push(feedback.m_appliedForceBodyB, j.linearB);
  push(feedback.m_appliedTorqueBodyA, j.angularA);
  push(feedback.m_appliedTorqueBodyB, j.angularB);
}

/// Soft bodies' objects are left to Bullet's solver, see surface_rigid.cpp.
bool holdsSoft(const btTypedConstraint& joint) {
  return SurfaceObject::from(&joint.getRigidBodyA()) || SurfaceObject::from(&joint.getRigidBodyB());
}

}  // namespace

void addRollingRows(const btPersistentManifold& manifold, const btManifoldPoint& point, TickContacts& found) {
  const double rolling = double(point.m_combinedRollingFriction);
  const double spinning = double(point.m_combinedSpinningFriction);
  if (!(rolling > 0.0) && !(spinning > 0.0)) return;
  const Vector3d normal = toEigen(point.m_normalWorldOnB).normalized();
  const Vector3d across = normal.unitOrthogonal();
  if (spinning > 0.0) addTurnRow(manifold, normal, spinning, found);
  if (!(rolling > 0.0)) return;
  addTurnRow(manifold, across, rolling, found);
  addTurnRow(manifold, normal.cross(across), rolling, found);
}

bool addJoinedBodies(btDiscreteDynamicsWorld& world, TickContacts& found) {
  const std::size_t before = found.rigids.size();
  for (int i = 0; i < world.getNumConstraints(); ++i) {
    btTypedConstraint& joint = *world.getConstraint(i);
    if (!joint.isEnabled() || holdsSoft(joint)) continue;
    btRigidBody &a = joint.getRigidBodyA(), &b = joint.getRigidBodyB();
    if (!isNumbered(found, a) && !isNumbered(found, b)) continue;
    for (btRigidBody* body : {&a, &b})
      if (isFree(*body)) found.add(*body);
  }
  return found.rigids.size() > before;
}

void addJointRows(btDiscreteDynamicsWorld& world, btScalar tick, TickContacts& found) {
  for (int i = 0; i < world.getNumConstraints(); ++i) {
    btTypedConstraint& joint = *world.getConstraint(i);
    if (joint.isEnabled() && !holdsSoft(joint) &&
        (isNumbered(found, joint.getRigidBodyA()) || isNumbered(found, joint.getRigidBodyB())))
      addRows(joint, world.getSolverInfo(), tick, found);
  }
}

void disableDrives(const TickContacts& found, std::vector<DisabledDrives>& off) {
  for (const JointSource& source : found.jointSources) {
    if (!source.drives || (!off.empty() && off.back().joint == source.constraint)) continue;
    off.push_back({source.constraint, switchOff(*source.constraint)});
  }
}

void enableDrives(btDynamicsWorld& world, std::vector<DisabledDrives>& off) {
  int place = 0;
  for (const DisabledDrives& o : off)
    if (isValid(world, o.joint, place)) switchOn(*o.joint, o.drives);
  off.clear();
}

void reportJoints(btDynamicsWorld& world, const TickContacts& contacts, btScalar tick) {
  int place = 0;
  for (std::size_t i = 0; i < contacts.joints.size(); ++i) {
    btTypedConstraint* constraint = contacts.jointSources[i].constraint;
    if (!constraint || !isValid(world, constraint, place)) continue;
    btTypedConstraint& joint = *constraint;
    const JointConstraint& row = contacts.joints[i];
    joint.internalSetAppliedImpulse(static_cast<btScalar>(row.impulse));
    if (joint.getJointFeedback()) addFeedback(*joint.getJointFeedback(), row, tick);
    if (std::abs(row.impulse) >= double(joint.getBreakingImpulseThreshold())) joint.setEnabled(false);
  }
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
