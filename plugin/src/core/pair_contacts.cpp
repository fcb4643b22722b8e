// SPDX-License-Identifier: Zlib
#include "core/pair_contacts.h"

#include <Eigen/Geometry>
#include <Eigen/LU>

#include <algorithm>
#include <cmath>

namespace limber {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// Contacts give way by this share of what one alone would give way to the change of its impulse since the
/// last substep (a proximal term), and normals to a fifth of the impulse itself. What contacts of rigid
/// bodies bear against each other, of which nothing else tells how it is shared out, then settles instead of
/// wandering, and piles come to rest. On a pile of ten boxes this costs 3e-5 m of height.
constexpr double kSoftness = 0.02, kFrictionSoftness = 0.05;
constexpr double kKept = 0.8;

/// Of the friction of a contact that slides: by so much at least a sweep turns it against the sliding.
/// Contacts of one body may bear friction against each other that does nothing but use up their cones;
/// without this a slow slide would take long to get it out.
constexpr double kLeastTurn = 0.1;

void addPoint(PairRows& rows, double* velocity, const Vector3d& inverseMass, double share) {
  const Vector3d response = share * inverseMass;
  rows.points.push_back({velocity, share, {response[0], response[1], response[2]}});
}

/// One side of a contact, in the world's axes; `sign` is 1 for a and -1 for b.
void addPlace(PairRows& rows, PairRow& row, LinkedBodies& bodies, const std::vector<PointView>& views,
              const ContactPlace& place, double sign) {
  if (place.kind == ContactPlace::Kind::World) {
    row.carried += sign * (row.axes.transpose() * place.velocity);
  } else if (place.kind == ContactPlace::Kind::Soft) {
    const PointView& view = views[place.body];
    for (std::uint32_t i = 0; i < place.count; ++i)
      addPoint(rows, view.velocityOf(place.point[i]).data(), view.inverseMassOf(place.point[i]),
               sign * place.weight[i]);
  } else {
    RigidState& rigid = bodies.rigids[place.body];
    addPoint(rows, rigid.velocity.data(), rigid.inverseMass, sign);
    RowTurn turn{&rigid, Matrix3d::Zero(), Matrix3d::Zero()};
    for (int k = 0; k < 3; ++k) turn.speeds.row(k) = sign * place.arm.cross(row.axes.col(k)).transpose();
    rows.turns.push_back(turn);
  }
}

void prepareMasses(PairRow& row, const Matrix3d& mobility) {
  row.mobility = mobility(0, 0);
  row.mass = row.mobility > 0.0 ? 1.0 / row.mobility : 0.0;
  row.acrossAlong[0] = mobility(1, 0);
  row.acrossAlong[1] = mobility(2, 0);
  const Eigen::Matrix2d across = mobility.bottomRightCorner<2, 2>();
  const bool moves = across.determinant() > 0.0;
  const Eigen::Matrix2d mass = moves ? Eigen::Matrix2d(across.inverse()) : Eigen::Matrix2d::Zero();
  row.acrossMass[0] = mass(0, 0), row.acrossMass[1] = mass(0, 1), row.acrossMass[2] = mass(1, 1);
  row.turnMass = 0.5 * mass.trace();
}

/// (along, across, across both)
Vector3d inAxes(const PairRow& row, const Bearing& bearing) {
  Vector3d v = row.axes.transpose() * bearing.across;
  v[0] = bearing.along;
  return v;
}

Bearing bearingOf(const PairRow& row, const Vector3d& v) {
  return {v[0], row.axes.col(1) * v[1] + row.axes.col(2) * v[2]};
}

void prepareRow(PairRows& rows, PairRow& row, const PairContact& c, LinkedBodies& bodies,
                const std::vector<PointView>& views) {
  const Vector3d tangent = c.normal.unitOrthogonal();
  row.axes << c.normal, tangent, c.normal.cross(tangent);
  row.carried.setZero();
  row.firstPoint = static_cast<std::uint32_t>(rows.points.size());
  row.firstTurn = static_cast<std::uint32_t>(rows.turns.size());
  addPlace(rows, row, bodies, views, c.a, 1.0);
  addPlace(rows, row, bodies, views, c.b, -1.0);
  row.endPoint = static_cast<std::uint32_t>(rows.points.size());
  row.endTurn = static_cast<std::uint32_t>(rows.turns.size());
  const Matrix3d m = mobility(bodies, c.a) + mobility(bodies, c.b);
  prepareMasses(row, row.axes.transpose() * m * row.axes);
  row.gap = c.gap;
  row.friction = c.friction;
  row.stopping = inAxes(row, c.stopping);
  row.settling = inAxes(row, c.settling);
  row.impulse.setZero();
}

void prepareJoint(JointRow& j, const LinkedBodies& bodies) {
  const auto share = [&](std::uint32_t body, const Vector3d& linear, const Vector3d& angular) {
    if (body == JointRow::kHeld) return 0.0;
    const RigidState& rigid = bodies.rigids[body];
    return linear.dot(linear.cwiseProduct(rigid.inverseMass)) + angular.dot(rigid.inverseInertia * angular);
  };
  const double mobility = share(j.a, j.linearA, j.angularA) + share(j.b, j.linearB, j.angularB);
  j.mass = mobility > 0.0 ? 1.0 / (mobility + j.softness) : 0.0;
  j.impulse = 0.0;
}

double speedOf(const LinkedBodies& bodies, const JointRow& j) {
  const auto share = [&](std::uint32_t body, const Vector3d& linear, const Vector3d& angular) {
    if (body == JointRow::kHeld) return 0.0;
    const RigidState& rigid = bodies.rigids[body];
    return linear.dot(rigid.velocity) + angular.dot(rigid.angularVelocity);
  };
  return share(j.a, j.linearA, j.angularA) + share(j.b, j.linearB, j.angularB);
}

/// Friction that stops the sliding (u, v) (m/s) altogether, or as much as there is, against the sliding.
inline void addFriction(const PairRow& row, double u, double v, Vector3d& sum) {
  constexpr double kShare = 1.0 / (1.0 + kFrictionSoftness);
  const double* m = row.acrossMass;
  const double most = row.friction * sum[0];
  const double strainU = kFrictionSoftness * (sum[1] - row.before[1]);
  const double strainV = kFrictionSoftness * (sum[2] - row.before[2]);
  const double stopU = sum[1] - (m[0] * u + m[1] * v + strainU) * kShare;
  const double stopV = sum[2] - (m[1] * u + m[2] * v + strainV) * kShare;
  if (stopU * stopU + stopV * stopV <= most * most) {
    sum[1] = stopU, sum[2] = stopV;
    return;
  }
  const double speed = std::sqrt(u * u + v * v);
  const double turn = speed > 0.0 ? std::max(row.turnMass, kLeastTurn * most / speed) : 0.0;
  sum[1] -= turn * u, sum[2] -= turn * v;
  const double squared = sum[1] * sum[1] + sum[2] * sum[2];
  if (squared <= most * most) return;
  const double scale = most / std::sqrt(squared);
  sum[1] *= scale, sum[2] *= scale;
}

}  // namespace

void preparePairs(PairRows& rows, LinkedBodies& bodies, const std::vector<PointView>& views) {
  rows.points.clear();
  rows.turns.clear();
  rows.rows.resize(rows.contacts.size());
  for (std::size_t i = 0; i < rows.contacts.size(); ++i)
    prepareRow(rows, rows.rows[i], rows.contacts[i], bodies, views);
  for (JointRow& j : rows.joints) prepareJoint(j, bodies);
}

void movePairs(PairRows& rows, double dt) {
  for (PairRow& row : rows.rows) row.gap += dt * speedAlong(rows, row);
}

void finishPairs(PairRows& rows) {
  for (std::size_t i = 0; i < rows.contacts.size(); ++i) {
    PairContact& c = rows.contacts[i];
    const PairRow& row = rows.rows[i];
    c.gap = row.gap;
    c.impulse = row.axes * row.impulse;
    c.stopping = bearingOf(row, row.stopping);
    c.settling = bearingOf(row, row.settling);
  }
}

void turnResponses(PairRows& rows) {
  for (RowTurn& turn : rows.turns) turn.response = turn.body->inverseInertia * turn.speeds.transpose();
}

void bear(LinkedBodies& bodies, JointRow& j, double change) {
  const auto push = [&](std::uint32_t body, const Vector3d& linear, const Vector3d& angular) {
    if (body == JointRow::kHeld) return;
    RigidState& rigid = bodies.rigids[body];
    rigid.velocity += change * linear.cwiseProduct(rigid.inverseMass);
    rigid.angularVelocity += change * (rigid.inverseInertia * angular);
  };
  push(j.a, j.linearA, j.angularA);
  push(j.b, j.linearB, j.angularB);
  j.impulse += change;
}

void solveContact(PairRows& rows, PairRow& row, Vector3d& sum, double target) {
  constexpr double kShare = 1.0 / (1.0 + kSoftness);
  const Vector3d speeds = speedsOf(rows, row), earlier = sum;
  const double wanted = (target - speeds[0]) * row.mass;
  const double strain = kSoftness * (sum[0] - kKept * row.before[0]);
  sum[0] = std::max(0.0, sum[0] + (wanted - strain) * kShare);
  const double along = sum[0] - earlier[0];
  addFriction(row, speeds[1] + along * row.acrossAlong[0], speeds[2] + along * row.acrossAlong[1], sum);
  row.change = sum - earlier;
  bear(rows, row, row.change);
}

void solveJoint(LinkedBodies& bodies, JointRow& j, double& sum) {
  const double wanted = sum + (j.speed - speedOf(bodies, j) - j.softness * sum) * j.mass;
  const double impulse = std::clamp(wanted, j.lower, j.upper);
  j.change = impulse - sum;
  sum = impulse;
  bear(bodies, j, j.change);
}

}  // namespace limber
