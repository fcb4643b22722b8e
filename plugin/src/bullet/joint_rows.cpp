// SPDX-License-Identifier: Zlib

// This file makes constraint rows from Bullet's joints and from rolling friction, and reports their impulses
// to Bullet.

#include "bullet/bullet_objects.h"
#include "bullet/surface_body.h"
#include "bullet/tick_contacts.h"

#include <cmath>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {
namespace {

using Eigen::Vector3d;

/// Bullet's largest constraint has six rows and a spring or motor for each.
constexpr int kMaxRows = 16;

/// The memory to which Bullet's constraints write their rows.
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

/// Returns the number of a side's body. The contribution of a kinematic body's motion goes to the other side
/// of the row's equation: it is subtracted from `speed`.
std::uint32_t sideOf(const btRigidBody& body, const Vector3d& linear, const Vector3d& angular,
                     const TickContacts& found, double& speed) {
  if (isFree(body)) return found.find(body);
  if (isKinematic(body)) {
    const btTransform &start = body.getWorldTransform(), &end = body.getInterpolationWorldTransform();
    const Vector3d moved = toEigen(btVector3(end.getOrigin() - start.getOrigin()));
    const Vector3d rotation = rotationBetween(toEigen(start.getRotation()), toEigen(end.getRotation()));
    speed -= (linear.dot(moved) + angular.dot(rotation)) / found.tick;
  }
  return JointConstraint::kHeld;
}

bool isDriven(const RowBuffer& buffer, int row) {
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

/// Adds a row against rotation of the two bodies of the last contact about `axis`. Its limit is `rolling` (m)
/// times the contact's impulse.
void addRotationRow(const btPersistentManifold& manifold, const Vector3d& axis, double rolling,
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

/// Fills the buffer in the same way as Bullet's solver. Returns the number of rows, or 0 if there are too
/// many.
int readRows(btTypedConstraint& joint, const btContactSolverInfo& solver, btScalar tick, RowBuffer& buffer) {
  joint.buildJacobian();
  btTypedConstraint::btConstraintInfo1 size;
  joint.getInfo1(&size);
  if (size.m_numConstraintRows <= 0 || size.m_numConstraintRows > kMaxRows) return 0;
  btTypedConstraint::btConstraintInfo2 info = infoOn(buffer, solver, tick);
  joint.getInfo2(&info);
  return size.m_numConstraintRows;
}

/// Moves both bodies of a joint, while this object exists, to the poses that define the joint's error: a
/// kinematic body to the end of the tick, where Bullet's solver sees it; a dynamic one along its velocity for
/// `time` (s).
class PredictedPoses {
 public:
  PredictedPoses(btTypedConstraint& joint, btScalar time)
      : bodies_{&joint.getRigidBodyA(), &joint.getRigidBodyB()},
        poses_{bodies_[0]->getWorldTransform(), bodies_[1]->getWorldTransform()} {
    for (btRigidBody* body : bodies_) {
      btTransform pose = body->getWorldTransform();
      if (isKinematic(*body))
        pose = body->getInterpolationWorldTransform();
      else if (isFree(*body) && time > btScalar(0))
        body->predictIntegratedTransform(time, pose);
      body->setWorldTransform(pose);
    }
  }
  ~PredictedPoses() {
    for (int i : {0, 1}) bodies_[i]->setWorldTransform(poses_[i]);
  }
  PredictedPoses(const PredictedPoses&) = delete;
  PredictedPoses& operator=(const PredictedPoses&) = delete;

 private:
  btRigidBody* bodies_[2];
  btTransform poses_[2];
};

bool hasSprings(const btTypedConstraint& joint) {
  const btTypedConstraintType type = joint.getConstraintType();
  return type == D6_SPRING_CONSTRAINT_TYPE || type == D6_SPRING_2_CONSTRAINT_TYPE;
}

/// Replaces the force of springs by that of half a tick later. The force is constant in the tick of length h.
/// If it is that of the distance x at the start, (x, v) is multiplied by a matrix of determinant 1 + (omega
/// h)^2 / 2, and oscillations grow. With the distance in the middle, x + h v / 2, the determinant is 1.
void copySprings(const RowBuffer& middle, int rows, RowBuffer& buffer) {
  for (int row = 0; row < rows; ++row) {
    if (!isDriven(buffer, row) || !isDriven(middle, row)) continue;
    buffer.error[4 * row] = middle.error[4 * row];
    buffer.lower[4 * row] = middle.lower[4 * row];
    buffer.upper[4 * row] = middle.upper[4 * row];
  }
}

void addRows(btTypedConstraint& joint, const btContactSolverInfo& solver, btScalar tick,
             TickContacts& found) {
  RowBuffer buffer, middle;
  int rows = 0, middleRows = 0;
  if (hasSprings(joint)) {
    const PredictedPoses poses(joint, tick / 2);
    middleRows = readRows(joint, solver, tick, middle);
  }
  {
    const PredictedPoses poses(joint, 0);
    rows = readRows(joint, solver, tick, buffer);
  }
  if (middleRows == rows) copySprings(middle, rows, buffer);
  for (int row = 0; row < rows; ++row) {
    const bool isDrive = isDriven(buffer, row);
    found.jointSources.push_back({&joint, isDrive ? 0.0 : double(buffer.error[4 * row]), isDrive});
    addRow(joint, buffer, row, tick, found);
  }
}

// --- motors and springs during Bullet's solver -------------------------------------------------------------

/// Calls visit(flag) for all flags of a joint that enable a motor or a spring.
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

/// Visits the motors and springs of Bullet's own joint types, by getters and setters where there are no
/// flags.
template <class Visit>
void visitDrives(btTypedConstraint& joint, Visit visit) {
  const auto visitProperty = [&](bool value, auto set) {
    const bool before = value;
    visit(value);
    if (value != before) set(value);
  };
  switch (joint.getConstraintType()) {
    case HINGE_CONSTRAINT_TYPE: {
      auto& hinge = static_cast<btHingeConstraint&>(joint);
      return visitProperty(hinge.getEnableAngularMotor(), [&](bool on) { hinge.enableMotor(on); });
    }
    case CONETWIST_CONSTRAINT_TYPE: {
      auto& cone = static_cast<btConeTwistConstraint&>(joint);
      return visitProperty(cone.isMotorEnabled(), [&](bool on) { cone.enableMotor(on); });
    }
    case SLIDER_CONSTRAINT_TYPE: {
      auto& slider = static_cast<btSliderConstraint&>(joint);
      visitProperty(slider.getPoweredLinMotor(), [&](bool on) { slider.setPoweredLinMotor(on); });
      return visitProperty(slider.getPoweredAngMotor(), [&](bool on) { slider.setPoweredAngMotor(on); });
    }
    case D6_SPRING_CONSTRAINT_TYPE: {
      auto& spring = static_cast<btGeneric6DofSpringConstraint&>(joint);
      // a spring acts through the motor of its axis, which is enabled with it
      for (int i = 0; i < 6; ++i)
        visitProperty(spring.isSpringEnabled(i), [&](bool on) { spring.enableSpring(i, on); });
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

/// Disables all drives. Returns one bit for each: whether it was enabled.
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

/// Returns whether the joint is in the world. Searches from `index` in the world's list on, and sets `index`
/// to its index: rows are in the order of their joints.
bool isValid(btDynamicsWorld& world, const btTypedConstraint* joint, int& index) {
  const int count = world.getNumConstraints();
  for (int i = 0; i < count; ++i) {
    const int candidate = (index + i) % count;
    if (world.getConstraint(candidate) != joint) continue;
    index = candidate;
    return true;
  }
  return false;
}

void addFeedback(btJointFeedback& feedback, const JointConstraint& j, btScalar tick) {
  const auto add = [&](btVector3& sum, const Vector3d& along) {
    sum += toBullet(along * (j.impulse / double(tick)));
  };
  add(feedback.m_appliedForceBodyA, j.linearA);
  add(feedback.m_appliedForceBodyB, j.linearB);
  add(feedback.m_appliedTorqueBodyA, j.angularA);
  add(feedback.m_appliedTorqueBodyB, j.angularB);
}

/// Returns whether a soft body is part of the joint. Bullet's solver handles these, see surface_rigid.cpp.
bool hasSoftBody(const btTypedConstraint& joint) {
  return SurfaceObject::from(&joint.getRigidBodyA()) || SurfaceObject::from(&joint.getRigidBodyB());
}

}  // namespace

void addRollingRows(const btPersistentManifold& manifold, const btManifoldPoint& point, TickContacts& found) {
  const double rolling = double(point.m_combinedRollingFriction);
  const double spinning = double(point.m_combinedSpinningFriction);
  if (!(rolling > 0.0) && !(spinning > 0.0)) return;
  const Vector3d normal = toEigen(point.m_normalWorldOnB).normalized();
  const Vector3d across = normal.unitOrthogonal();
  if (spinning > 0.0) addRotationRow(manifold, normal, spinning, found);
  if (!(rolling > 0.0)) return;
  addRotationRow(manifold, across, rolling, found);
  addRotationRow(manifold, normal.cross(across), rolling, found);
}

bool addJoinedBodies(btDiscreteDynamicsWorld& world, TickContacts& found) {
  const std::size_t before = found.rigids.size();
  for (int i = 0; i < world.getNumConstraints(); ++i) {
    btTypedConstraint& joint = *world.getConstraint(i);
    if (!joint.isEnabled() || hasSoftBody(joint)) continue;
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
    if (joint.isEnabled() && !hasSoftBody(joint) &&
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
  int index = 0;
  for (const DisabledDrives& o : off)
    if (isValid(world, o.joint, index)) switchOn(*o.joint, o.drives);
  off.clear();
}

void reportJoints(btDynamicsWorld& world, const TickContacts& contacts, btScalar tick) {
  int index = 0;
  for (std::size_t i = 0; i < contacts.joints.size(); ++i) {
    btTypedConstraint* constraint = contacts.jointSources[i].constraint;
    if (!constraint || !isValid(world, constraint, index)) continue;
    btTypedConstraint& joint = *constraint;
    const JointConstraint& row = contacts.joints[i];
    joint.internalSetAppliedImpulse(static_cast<btScalar>(row.impulse));
    if (joint.getJointFeedback()) addFeedback(*joint.getJointFeedback(), row, tick);
    if (std::abs(row.impulse) >= double(joint.getBreakingImpulseThreshold())) joint.setEnabled(false);
  }
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
