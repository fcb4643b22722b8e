// SPDX-License-Identifier: Zlib
#include "core/pair_contacts.h"

#include <Eigen/Geometry>
#include <Eigen/LU>

#include <algorithm>
#include <cmath>

namespace limber {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
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

void prepareContact(PairContact& c, const LinkedBodies& bodies) {
  const Matrix3d m = mobility(bodies, c.a) + mobility(bodies, c.b);
  const double along = c.normal.dot(m * c.normal);
  c.mass = along > 0.0 ? 1.0 / along : 0.0;
  c.tangents.col(0) = c.normal.unitOrthogonal();
  c.tangents.col(1) = c.normal.cross(c.tangents.col(0));
  c.acrossAlong = c.tangents.transpose() * m * c.normal;
  const Eigen::Matrix2d across = c.tangents.transpose() * m * c.tangents;
  c.acrossMass.setZero();
  if (across.determinant() > 0.0) c.acrossMass = across.inverse();
  c.impulse.setZero();
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

/// Friction that stops the sliding `across` (m/s) altogether, or as much as there is, against the sliding.
void addFriction(const PairContact& c, const Vector2d& across, Bearing& sum) {
  const double most = c.friction * sum.along;
  const Vector3d strain = kFrictionSoftness * (sum.across - c.before.across);
  const Vector3d stopping =
      sum.across - (c.tangents * (c.acrossMass * across) + strain) / (1.0 + kFrictionSoftness);
  if (stopping.squaredNorm() <= most * most) {
    sum.across = stopping;
    return;
  }
  const double speed = across.norm();
  const double turn = speed > 0.0 ? std::max(0.5 * c.acrossMass.trace(), kLeastTurn * most / speed) : 0.0;
  sum.across -= turn * (c.tangents * across);
  const double length = sum.across.norm();
  if (length > most) sum.across *= most / length;
}

}  // namespace

void preparePairs(PairRows& rows, const LinkedBodies& bodies) {
  for (PairContact& c : rows.contacts) prepareContact(c, bodies);
  for (JointRow& j : rows.joints) prepareJoint(j, bodies);
}

void movePairs(PairRows& rows, const LinkedBodies& bodies, double dt) {
  for (PairContact& c : rows.contacts)
    c.gap += dt * c.normal.dot(velocityAt(bodies, c.a) - velocityAt(bodies, c.b));
}

void bear(LinkedBodies& bodies, PairContact& c, const Bearing& change) {
  const Vector3d impulse = change.along * c.normal + change.across;
  push(bodies, c.a, impulse);
  push(bodies, c.b, -impulse);
  c.impulse += impulse;
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

void solveContact(LinkedBodies& bodies, PairContact& c, Bearing& sum, double target) {
  const Vector3d relative = velocityAt(bodies, c.a) - velocityAt(bodies, c.b);
  c.change = sum;
  const double wanted = (target - c.normal.dot(relative)) * c.mass;
  const double strain = kSoftness * (sum.along - kKept * c.before.along);
  sum.along = std::max(0.0, sum.along + (wanted - strain) / (1.0 + kSoftness));
  c.change.along = sum.along - c.change.along;
  addFriction(c, c.tangents.transpose() * relative + c.change.along * c.acrossAlong, sum);
  c.change.across = sum.across - c.change.across;
  bear(bodies, c, c.change);
}

void solveJoint(LinkedBodies& bodies, JointRow& j, double& sum) {
  const double wanted = sum + (j.speed - speedOf(bodies, j) - j.softness * sum) * j.mass;
  const double impulse = std::clamp(wanted, j.lower, j.upper);
  j.change = impulse - sum;
  sum = impulse;
  bear(bodies, j, j.change);
}

}  // namespace limber
