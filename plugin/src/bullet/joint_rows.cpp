// SPDX-License-Identifier: Zlib
#include "bullet/joint_rows.h"

#include "bullet/convert.h"
#include "bullet/surface_object.h"

#include <cmath>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {
namespace {

using Eigen::Vector3d;

/// Bullet's largest kind of constraint has six rows and a spring or motor for each.
constexpr int kMostRows = 16;

/// Where Bullet's constraints write their rows.
struct RowBuffer {
  btScalar linearA[4 * kMostRows] = {}, angularA[4 * kMostRows] = {};
  btScalar linearB[4 * kMostRows] = {}, angularB[4 * kMostRows] = {};
  btScalar error[4 * kMostRows] = {}, softness[4 * kMostRows] = {};
  btScalar lower[4 * kMostRows], upper[4 * kMostRows];
};

Vector3d vectorAt(const btScalar* numbers, int row) {
  return {double(numbers[4 * row]), double(numbers[4 * row + 1]), double(numbers[4 * row + 2])};
}

btTypedConstraint::btConstraintInfo2 infoOn(RowBuffer& buffer, const btContactSolverInfo& solver,
                                            btScalar tick) {
  for (int i = 0; i < 4 * kMostRows; ++i) {
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
  if (!isStatic(body) && body.isActive())
    speed -= linear.dot(toEigen(body.getLinearVelocity())) + angular.dot(toEigen(body.getAngularVelocity()));
  return JointRow::kHeld;
}

void addRow(const btTypedConstraint& joint, const RowBuffer& buffer, int row, btScalar tick,
            TickContacts& found) {
  JointRow j;
  j.linearA = vectorAt(buffer.linearA, row), j.angularA = vectorAt(buffer.angularA, row);
  j.linearB = vectorAt(buffer.linearB, row), j.angularB = vectorAt(buffer.angularB, row);
  const double most = double(joint.getBreakingImpulseThreshold());
  j.lower = std::max(double(buffer.lower[4 * row]), -most);
  j.upper = std::min(double(buffer.upper[4 * row]), most);
  j.speed = double(buffer.error[4 * row]);
  // motors have limits on both sides
  const bool isMotor = buffer.lower[4 * row] > -SIMD_INFINITY && buffer.upper[4 * row] < SIMD_INFINITY;
  found.recoveries.push_back(isMotor ? 0.0 : j.speed);
  j.softness = double(buffer.softness[4 * row] / tick);
  j.a = sideOf(joint.getRigidBodyA(), j.linearA, j.angularA, found, j.speed);
  j.b = sideOf(joint.getRigidBodyB(), j.linearB, j.angularB, found, j.speed);
  found.joints.push_back(j);
}

/// Against turning of the sides of the last contact against each other, by `rolling` (m) times what it bears.
void addTurnRow(const btPersistentManifold& manifold, const Vector3d& axis, double rolling,
                TickContacts& found) {
  JointRow j;
  j.contact = static_cast<std::uint32_t>(found.contacts.size() - 1);
  j.rolling = rolling;
  j.linearA = j.linearB = Vector3d::Zero();
  j.angularA = axis, j.angularB = -axis;
  const auto side = [&](const btCollisionObject* object, const Vector3d& angular) {
    const btRigidBody* body = btRigidBody::upcast(object);
    return body ? sideOf(*body, Vector3d::Zero(), angular, found, j.speed) : JointRow::kHeld;
  };
  j.a = side(manifold.getBody0(), j.angularA);
  j.b = side(manifold.getBody1(), j.angularB);
  found.joints.push_back(j);
  found.constraints.push_back(nullptr);
  found.recoveries.push_back(0.0);
}

bool isNumbered(const TickContacts& found, const btRigidBody& body) {
  return isFree(body) && found.find(body) != TickContacts::kNone;
}

void addRows(btTypedConstraint& joint, const btContactSolverInfo& solver, btScalar tick,
             TickContacts& found) {
  joint.buildJacobian();
  btTypedConstraint::btConstraintInfo1 size;
  joint.getInfo1(&size);
  if (size.m_numConstraintRows <= 0 || size.m_numConstraintRows > kMostRows) return;
  RowBuffer buffer;
  btTypedConstraint::btConstraintInfo2 info = infoOn(buffer, solver, tick);
  joint.getInfo2(&info);
  for (int row = 0; row < size.m_numConstraintRows; ++row) {
    addRow(joint, buffer, row, tick, found);
    found.constraints.push_back(&joint);
  }
}

/// Whether the joint is in the world. Looks from `place` in the world's list on, and leaves there where it
/// is: rows come in the order of their joints.
bool isThere(btDynamicsWorld& world, const btTypedConstraint* joint, int& place) {
  const int count = world.getNumConstraints();
  for (int i = 0; i < count; ++i) {
    const int here = (place + i) % count;
    if (world.getConstraint(here) != joint) continue;
    place = here;
    return true;
  }
  return false;
}

void addFeedback(btJointFeedback& feedback, const JointRow& j, btScalar tick) {
  const auto push = [&](btVector3& sum, const Vector3d& along) {
    sum += toBullet(Vector3d(along * (j.impulse / double(tick))));
  };
  push(feedback.m_appliedForceBodyA, j.linearA);
  push(feedback.m_appliedForceBodyB, j.linearB);
  push(feedback.m_appliedTorqueBodyA, j.angularA);
  push(feedback.m_appliedTorqueBodyB, j.angularB);
}

/// Soft bodies' objects are left to Bullet's solver, see surface_rigid.h.
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

void reportJoints(btDynamicsWorld& world, const TickContacts& contacts, btScalar tick) {
  int place = 0;
  for (std::size_t i = 0; i < contacts.joints.size(); ++i) {
    if (!contacts.constraints[i] || !isThere(world, contacts.constraints[i], place)) continue;
    btTypedConstraint& joint = *contacts.constraints[i];
    const JointRow& row = contacts.joints[i];
    joint.internalSetAppliedImpulse(static_cast<btScalar>(row.impulse));
    if (joint.getJointFeedback()) addFeedback(*joint.getJointFeedback(), row, tick);
    if (std::abs(row.impulse) >= double(joint.getBreakingImpulseThreshold())) joint.setEnabled(false);
  }
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
