// SPDX-License-Identifier: Zlib
#pragma once

// Basic operations on one row of contacts or joints.

#include "solver/contacts.h"

namespace limber {

/// Components (normal, tangents) of a vector.
inline Eigen::Vector3d inAxes(const ContactConstraint& row, const Eigen::Vector3d& v) {
  using ConstMap = Eigen::Map<const Eigen::Vector3d>;
  return {ConstMap(row.axes[0]).dot(v), ConstMap(row.axes[1]).dot(v), ConstMap(row.axes[2]).dot(v)};
}

/// Sets the row's masses from the speeds per impulse (1/kg) along the normal and both tangents.
void setMobility(ContactConstraint& row, const Eigen::Matrix3d& mobility);

/// Sets the share of point i, which has an inverse mass.
inline void setShare(IslandConstraints& rows, std::uint32_t i, double share) {
  rows.points[i].share = share;
  for (int k = 0; k < 3; ++k) rows.points[i].response[k] = share * rows.momentArms[i].inverseMass[k];
}

/// Calls visit(rigid, linear, angular) for each side of the joint that can move.
template <class Rigids, class Visit>
void forEachSide(Rigids& rigids, const JointConstraint& j, Visit visit) {
  if (j.a != JointConstraint::kHeld) visit(rigids[j.a], j.linearA, j.angularA);
  if (j.b != JointConstraint::kHeld) visit(rigids[j.b], j.linearB, j.angularB);
}

struct Motion {
  double x = 0.0, y = 0.0, z = 0.0;
};

/// m/s, of side a relative to b without the rotation of rigid bodies.
inline Motion motionOf(const IslandConstraints& rows, const ContactConstraint& row) {
  Motion m;
  for (std::uint32_t i = row.firstPoint; i < row.endPoint; ++i) {
    const ConstraintPoint& p = rows.points[i];
    m.x += p.share * p.velocity[0];
    m.y += p.share * p.velocity[1];
    m.z += p.share * p.velocity[2];
  }
  return m;
}

inline double along(const double* axis, const Motion& m) {
  return axis[0] * m.x + axis[1] * m.y + axis[2] * m.z;
}

inline Motion angularVelocityOf(const ConstraintRotation& rotation) {
  const Eigen::Vector3d& w = rotation.body->angularVelocity;
  return {w.x(), w.y(), w.z()};
}

/// Returns the tangential speeds (m/s) that the points' normal speeds add at their moment arms.
inline ContactVector momentArmSpeeds(const IslandConstraints& rows, const ContactConstraint& row) {
  ContactVector speeds;
  for (std::uint32_t i = row.firstPoint; i < row.endPoint; ++i) {
    const double* v = rows.points[i].velocity;
    const double speed = along(row.axes[0], {v[0], v[1], v[2]});
    speeds.u += rows.momentArms[i].across[0] * speed;
    speeds.v += rows.momentArms[i].across[1] * speed;
  }
  return speeds;
}

inline void applyAtMomentArms(IslandConstraints& rows, const ContactConstraint& row, const ContactVector& j) {
  for (std::uint32_t i = row.firstPoint; i < row.endPoint; ++i) {
    const MomentArm& momentArm = rows.momentArms[i];
    const double impulse = momentArm.across[0] * j.u + momentArm.across[1] * j.v;
    for (int k = 0; k < 3; ++k) rows.points[i].velocity[k] += momentArm.response[k] * impulse;
  }
}

/// m/s, of side a relative to b.
inline ContactVector speedsOf(const IslandConstraints& rows, const ContactConstraint& row) {
  const Motion m = motionOf(rows, row);
  ContactVector speeds{row.surfaceSpeeds.n + along(row.axes[0], m),
                       row.surfaceSpeeds.u + along(row.axes[1], m),
                       row.surfaceSpeeds.v + along(row.axes[2], m)};
  for (std::uint32_t i = row.firstRotation; i < row.endRotation; ++i) {
    const ConstraintRotation& t = rows.rotations[i];
    const Motion w = angularVelocityOf(t);
    speeds += {along(t.speeds[0], w), along(t.speeds[1], w), along(t.speeds[2], w)};
  }
  if (row.couple == Couple::Soft) speeds += momentArmSpeeds(rows, row);
  return speeds;
}

/// speedsOf().n
inline double speedAlong(const IslandConstraints& rows, const ContactConstraint& row) {
  double speed = row.surfaceSpeeds.n + along(row.axes[0], motionOf(rows, row));
  for (std::uint32_t i = row.firstRotation; i < row.endRotation; ++i)
    speed += along(rows.rotations[i].speeds[0], angularVelocityOf(rows.rotations[i]));
  return speed;
}

/// Applies an impulse to both sides.
inline void applyImpulse(IslandConstraints& rows, ContactConstraint& row, const ContactVector& j) {
  const double(&a)[3][3] = row.axes;
  const double x = a[0][0] * j.n + a[1][0] * j.u + a[2][0] * j.v;
  const double y = a[0][1] * j.n + a[1][1] * j.u + a[2][1] * j.v;
  const double z = a[0][2] * j.n + a[1][2] * j.u + a[2][2] * j.v;
  for (std::uint32_t i = row.firstPoint; i < row.endPoint; ++i) {
    const ConstraintPoint& p = rows.points[i];
    p.velocity[0] += p.response[0] * x;
    p.velocity[1] += p.response[1] * y;
    p.velocity[2] += p.response[2] * z;
  }
  for (std::uint32_t i = row.firstRotation; i < row.endRotation; ++i) {
    const ConstraintRotation& t = rows.rotations[i];
    double* w = t.body->angularVelocity.data();
    for (int k = 0; k < 3; ++k)
      w[k] += t.response[0][k] * j.n + t.response[1][k] * j.u + t.response[2][k] * j.v;
  }
  if (row.couple == Couple::Soft) applyAtMomentArms(rows, row, j);
  row.impulse += j;
}

}  // namespace limber
