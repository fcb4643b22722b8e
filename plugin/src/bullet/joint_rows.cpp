// SPDX-License-Identifier: Zlib

// This file makes constraint rows from Bullet's joints and from rolling friction, and reports their impulses
// to Bullet.

#include "bullet/surface_body.h"
#include "bullet/tick_contacts.h"

#include <Eigen/QR>

#include <cmath>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {
namespace {

using Eigen::Vector3d;

/// Bullet's largest constraint has two limits, a spring and a motor for each of six axes.
constexpr int kMaxRows = 24;

/// A row in the layout of Bullet's constraints.
struct Row {
  btVector3 linearA, angularA, linearB, angularB;
  btScalar error, softness, lower, upper;

  bool isDriven() const { return lower > -SIMD_INFINITY && upper < SIMD_INFINITY; }
};

struct Rows {
  Row rows[kMaxRows];
  int count = 0;  ///< 0 if the constraint has too many
};

btTypedConstraint::btConstraintInfo2 infoOn(Rows& buffer, const btContactSolverInfo& solver, btScalar tick) {
  const btVector3 zero(0, 0, 0);
  for (Row& row : buffer.rows) row = {zero, zero, zero, zero, 0, 0, -SIMD_INFINITY, SIMD_INFINITY};
  Row& first = buffer.rows[0];
  first.softness = solver.m_globalCfm;  // Bullet's solver sets that of the first row only
  btTypedConstraint::btConstraintInfo2 info;
  info.fps = btScalar(1) / tick;
  info.erp = solver.m_erp;
  info.m_J1linearAxis = first.linearA, info.m_J1angularAxis = first.angularA;
  info.m_J2linearAxis = first.linearB, info.m_J2angularAxis = first.angularB;
  info.rowskip = sizeof(Row) / sizeof(btScalar);
  info.m_constraintError = &first.error;
  info.cfm = &first.softness;
  info.m_lowerLimit = &first.lower, info.m_upperLimit = &first.upper;
  info.m_numIterations = solver.m_numIterations;
  info.m_damping = solver.m_damping;
  return info;
}

/// Returns whether the step moves the body.
bool isStepped(const btRigidBody& body) {
  const SurfaceObject* surface = SurfaceObject::from(&body);
  if (!surface) return isFree(body);
  return surface->owner() && surface->owner()->alive && !surface->owner()->asleep &&
         body.getActivationState() != DISABLE_SIMULATION;
}

/// Returns the number of a side's body. The contribution of a kinematic body's motion goes to the other side
/// of the row's equation: it is subtracted from `speed`.
std::uint32_t sideOf(const btRigidBody& body, const Vector3d& linear, const Vector3d& angular,
                     const TickContacts& found, double& speed) {
  if (isStepped(body)) return found.find(body);
  if (isKinematic(body)) {
    const btTransform &start = body.getWorldTransform(), &end = body.getInterpolationWorldTransform();
    const Vector3d moved = toEigen(btVector3(end.getOrigin() - start.getOrigin()));
    const Vector3d rotation = rotationBetween(toEigen(start.getRotation()), toEigen(end.getRotation()));
    speed -= (linear.dot(moved) + angular.dot(rotation)) / found.tick;
  }
  return JointConstraint::kHeld;
}

/// Returns whether the joint is of one of Bullet's types whose rows without limits hold positions.
bool isBullets(const btTypedConstraint& joint) {
  const btTypedConstraintType type = joint.getConstraintType();
  return (type >= POINT2POINT_CONSTRAINT_TYPE && type <= SLIDER_CONSTRAINT_TYPE) ||
         type == D6_SPRING_CONSTRAINT_TYPE || type == D6_SPRING_2_CONSTRAINT_TYPE ||
         type == FIXED_CONSTRAINT_TYPE;
}

/// Sets what the speed of a row consists of: that of error correction and that of a kinematic side. Bullet
/// takes the error where the kinematic body is at the end of the tick, so its motion is also in the
/// correction, and in the velocities of what follows it. Others do not keep the speed of a correction: joints
/// that contradict each other would push for ever. Limits may bounce.
JointSource splitSpeed(btTypedConstraint& joint, const Row& row, double erp, JointConstraint& j) {
  const double error = double(row.error), kinematic = j.speed - error;
  if (j.isDriven) return {&joint, kinematic, true};
  j.recovery = error - erp * kinematic;
  const bool isLimit = row.lower > -SIMD_INFINITY || row.upper < SIMD_INFINITY;
  if (kinematic == 0.0 && !isLimit && isBullets(joint)) j.correction = error;
  return {&joint, (1.0 + erp) * kinematic, false};
}

void addRow(btTypedConstraint& joint, const Row& row, btScalar erp, TickContacts& found) {
  JointConstraint j;
  j.linearA = toEigen(row.linearA), j.angularA = toEigen(row.angularA);
  j.linearB = toEigen(row.linearB), j.angularB = toEigen(row.angularB);
  if (row.lower > -SIMD_INFINITY) j.lower = double(row.lower);
  if (row.upper < SIMD_INFINITY) j.upper = double(row.upper);
  j.isDriven = row.isDriven();
  j.speed = double(row.error);
  j.yielding = double(row.softness);
  j.a = sideOf(joint.getRigidBodyA(), j.linearA, j.angularA, found, j.speed);
  j.b = sideOf(joint.getRigidBodyB(), j.linearB, j.angularB, found, j.speed);
  found.jointSources.push_back(splitSpeed(joint, row, double(erp), j));
  found.joints.push_back(j);
}

/// Adds a row against rotation of the two bodies of the last contact about `axis`. Its limit is `rolling` (m)
/// times the contact's impulse.
void addRotationRow(const btCollisionObject& a, const btCollisionObject& b, const Vector3d& axis,
                    double rolling, TickContacts& found) {
  JointConstraint j;
  j.contact = static_cast<std::uint32_t>(found.contacts.size() - 1);
  j.rolling = rolling;
  j.linearA = j.linearB = Vector3d::Zero();
  j.angularA = axis, j.angularB = -axis;
  const auto side = [&](const btCollisionObject& object, const Vector3d& angular) {
    const btRigidBody* body = btRigidBody::upcast(&object);
    return body ? sideOf(*body, Vector3d::Zero(), angular, found, j.speed) : JointConstraint::kHeld;
  };
  j.a = side(a, j.angularA);
  j.b = side(b, j.angularB);
  found.joints.push_back(j);
  found.jointSources.emplace_back();
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

/// Changes, while this object exists, limits of a btGeneric6DofConstraint that its present position meets
/// exactly: the joint has no row for such an axis, though it is locked, and the step often leaves no error.
class NudgedLimits {
 public:
  /// Calculates the position.
  explicit NudgedLimits(btTypedConstraint& joint) {
    const btTypedConstraintType type = joint.getConstraintType();
    if (type != D6_CONSTRAINT_TYPE && type != D6_SPRING_CONSTRAINT_TYPE) return;
    joint_ = static_cast<btGeneric6DofConstraint*>(&joint);
    joint_->calculateTransforms();
    forEachAxis([&](int i, btScalar position, btScalar& lower, btScalar& upper) {
      limits_[i] = lower;
      isNudged_[i] = lower == upper && position == lower;
      if (isNudged_[i]) lower = upper = lower + btMax(btFabs(lower) * SIMD_EPSILON, btScalar(1e-12));
    });
  }
  ~NudgedLimits() {
    if (!joint_) return;
    forEachAxis([&](int i, btScalar, btScalar& lower, btScalar& upper) {
      if (isNudged_[i]) lower = upper = limits_[i];
    });
  }
  NudgedLimits(const NudgedLimits&) = delete;
  NudgedLimits& operator=(const NudgedLimits&) = delete;

 private:
  /// Calls visit(axis, position, lower limit, upper limit) for the three shifts and the three angles.
  template <class Visit>
  void forEachAxis(Visit visit) {
    btTranslationalLimitMotor& shifts = *joint_->getTranslationalLimitMotor();
    for (int i : {0, 1, 2}) {
      visit(i, joint_->getRelativePivotPosition(i), shifts.m_lowerLimit[i], shifts.m_upperLimit[i]);
      btRotationalLimitMotor& angle = *joint_->getRotationalLimitMotor(i);
      visit(3 + i, joint_->getAngle(i), angle.m_loLimit, angle.m_hiLimit);
    }
  }

  btGeneric6DofConstraint* joint_ = nullptr;
  btScalar limits_[6];
  bool isNudged_[6];
};

/// Returns the rows as Bullet's solver gets them, with the bodies moved by PredictedPoses.
Rows readRows(btTypedConstraint& joint, const btContactSolverInfo& solver, btScalar tick, btScalar time) {
  const PredictedPoses poses(joint, time);
  Rows buffer;
  joint.buildJacobian();
  const NudgedLimits limits(joint);
  btTypedConstraint::btConstraintInfo1 size;
  joint.getInfo1(&size);
  if (size.m_numConstraintRows > kMaxRows) return buffer;
  buffer.count = size.m_numConstraintRows;
  btTypedConstraint::btConstraintInfo2 info = infoOn(buffer, solver, tick);
  if (buffer.count > 0) joint.getInfo2(&info);
  return buffer;
}

/// Replaces the force of springs by that of half a tick later. The force is constant in the tick of length h.
/// If it is that of the distance x at the start, (x, v) is multiplied by a matrix of determinant 1 + (omega
/// h)^2 / 2, and oscillations grow. With the distance in the middle, x + h v / 2, the determinant is 1.
/// Rows of limits and springs may come and go between the two; those of one axis are of the same spring.
void copySprings(const Rows& middle, Rows& buffer) {
  const auto isSpringOf = [](const Row& row) {
    return [&row](const Row& later) {
      const btVector3 Row::*const axis = row.linearA.isZero() ? &Row::angularA : &Row::linearA;
      return later.isDriven() && (later.*axis).dot(row.*axis) > btScalar(0.7) * (row.*axis).length2();
    };
  };
  const Row *next = middle.rows, *const end = middle.rows + middle.count;
  for (Row* row = buffer.rows; row != buffer.rows + buffer.count; ++row) {
    if (!row->isDriven()) continue;
    const Row* const later = std::find_if(next, end, isSpringOf(*row));
    if (later == end) continue;
    row->error = later->error, row->lower = later->lower, row->upper = later->upper;
    next = later + 1;
  }
}

/// Returns the arm r (m) of the pivot for which the angular parts a of a side's rows are nearest to  r x n,
/// with the linear parts n:  sum (|n|^2 - n n^T) r = sum n x a.  Where there is one row, r is across it.
Vector3d armOf(const Rows& rows, btVector3 Row::*linear, btVector3 Row::*angular) {
  Eigen::Matrix3d matrix = Eigen::Matrix3d::Zero();
  Vector3d sum = Vector3d::Zero();
  for (int i = 0; i < rows.count; ++i) {
    const Vector3d n = toEigen(rows.rows[i].*linear), a = toEigen(rows.rows[i].*angular);
    matrix += n.squaredNorm() * Eigen::Matrix3d::Identity() - n * n.transpose();
    sum += n.cross(a);
  }
  if (matrix.isZero(0.0)) return Vector3d::Zero();
  return matrix.completeOrthogonalDecomposition().solve(sum);
}

void addRows(btTypedConstraint& joint, const btContactSolverInfo& solver, btScalar tick,
             TickContacts& found) {
  const btTypedConstraintType type = joint.getConstraintType();
  const bool hasSprings = type == D6_SPRING_CONSTRAINT_TYPE || type == D6_SPRING_2_CONSTRAINT_TYPE;
  // the joint itself must end with the state of the present poses
  const Rows middle = hasSprings ? readRows(joint, solver, tick, tick / 2) : Rows();
  Rows buffer = readRows(joint, solver, tick, 0);
  copySprings(middle, buffer);
  const Vector3d armA = armOf(buffer, &Row::linearA, &Row::angularA),
                 armB = armOf(buffer, &Row::linearB, &Row::angularB);
  for (int i = 0; i < buffer.count; ++i) {
    addRow(joint, buffer.rows[i], solver.m_erp, found);
    found.joints.back().armA = armA, found.joints.back().armB = armB;
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

/// An impulse clamp (N s) that leaves nothing; 0 would be no clamp.
constexpr btScalar kNoImpulse = btScalar(1e-30);

/// A row with a clamp has both limits: it pulls with its impulse like a motor.
btScalar switchOffClamp(btTypedConstraint& joint) {
  if (joint.getConstraintType() != POINT2POINT_CONSTRAINT_TYPE) return 0;
  return std::exchange(static_cast<btPoint2PointConstraint&>(joint).m_setting.m_impulseClamp, kNoImpulse);
}

/// Leaves drives and a clamp as they are that the user has enabled or set since.
void switchOn(const DisabledDrives& off) {
  std::uint32_t on = off.drives;
  visitDrives(*off.joint, [&](bool& flag) {
    if (on & 1u) flag = true;
    on >>= 1;
  });
  if (!(off.clamp > btScalar(0))) return;
  btScalar& clamp = static_cast<btPoint2PointConstraint&>(*off.joint).m_setting.m_impulseClamp;
  if (clamp == kNoImpulse) clamp = off.clamp;
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

/// Calls visit(joint) for the enabled joints of numbered bodies.
template <class Visit>
void forEachJoint(btDiscreteDynamicsWorld& world, const TickContacts& found, Visit visit) {
  const auto isNumbered = [&](const btRigidBody& body) {
    return isStepped(body) && found.find(body) != TickContacts::kNone;
  };
  for (int i = 0; i < world.getNumConstraints(); ++i) {
    btTypedConstraint& joint = *world.getConstraint(i);
    const btRigidBody &a = joint.getRigidBodyA(), &b = joint.getRigidBodyB();
    if (joint.isEnabled() && (isNumbered(a) || isNumbered(b))) visit(joint);
  }
}

}  // namespace

void addRollingRows(const btCollisionObject& a, const btCollisionObject& b, const btManifoldPoint& point,
                    TickContacts& found) {
  const double rolling = double(point.m_combinedRollingFriction);
  const double spinning = double(point.m_combinedSpinningFriction);
  if (!(rolling > 0.0) && !(spinning > 0.0)) return;
  const Vector3d normal = toEigen(point.m_normalWorldOnB).normalized();
  const Vector3d across = normal.unitOrthogonal();
  if (spinning > 0.0) addRotationRow(a, b, normal, spinning, found);
  if (!(rolling > 0.0)) return;
  addRotationRow(a, b, across, rolling, found);
  addRotationRow(a, b, normal.cross(across), rolling, found);
}

void addJointedSurfaces(btDiscreteDynamicsWorld& world, TickContacts& found) {
  for (int i = 0; i < world.getNumConstraints(); ++i) {
    btTypedConstraint& joint = *world.getConstraint(i);
    if (!joint.isEnabled()) continue;
    for (btRigidBody* body : {&joint.getRigidBodyA(), &joint.getRigidBodyB()})
      if (SurfaceObject::from(body) && isStepped(*body)) found.add(*body);
  }
}

bool addJoinedBodies(btDiscreteDynamicsWorld& world, TickContacts& found) {
  const std::size_t before = found.rigids.size();
  forEachJoint(world, found, [&](btTypedConstraint& joint) {
    for (btRigidBody* body : {&joint.getRigidBodyA(), &joint.getRigidBodyB()}) {
      if (isSleepingBody(*body) && !SurfaceObject::from(body)) wakeInStep(*body);
      if (isStepped(*body)) found.add(*body);
    }
  });
  return found.rigids.size() > before;
}

void addJointRows(btDiscreteDynamicsWorld& world, btScalar tick, TickContacts& found) {
  forEachJoint(world, found,
               [&](btTypedConstraint& joint) { addRows(joint, world.getSolverInfo(), tick, found); });
}

void disableDrives(const TickContacts& found, std::vector<DisabledDrives>& off) {
  for (const JointSource& source : found.jointSources) {
    if (!source.drives || (!off.empty() && off.back().joint == source.constraint)) continue;
    off.push_back({source.constraint, switchOff(*source.constraint), switchOffClamp(*source.constraint)});
  }
}

void enableDrives(btDynamicsWorld& world, std::vector<DisabledDrives>& off) {
  int index = 0;
  for (const DisabledDrives& o : off)
    if (isValid(world, o.joint, index)) switchOn(o);
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
