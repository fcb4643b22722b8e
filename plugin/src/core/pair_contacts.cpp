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

/// As in contact_rows.cpp.
constexpr double kRecovery = 0.2;

constexpr int kMostSweeps = 24;

/// Which of a row's two impulses a solve is about.
enum class Stage { Stopping, Settling };

Bearing& bearingOf(PairContact& c, Stage stage) { return stage == Stage::Stopping ? c.stopping : c.settling; }
double& impulseOf(JointRow& j, Stage stage) { return stage == Stage::Stopping ? j.stopping : j.settling; }

void bear(LinkedBodies& bodies, PairContact& c, const Bearing& change) {
  const Vector3d impulse = change.along * c.normal + change.across;
  push(bodies, c.a, impulse);
  push(bodies, c.b, -impulse);
  c.impulse += impulse;
}

/// Of the friction of a contact that slides: by so much at least a sweep turns it against the sliding.
/// Contacts of one body may bear friction against each other that does nothing but use up their cones;
/// without this a slow slide would take long to get it out.
constexpr double kLeastTurn = 0.1;

/// Friction that stops the sliding `across` (m/s) altogether, or as much as there is, against the sliding.
void addFriction(const PairContact& c, const Vector2d& across, Bearing& sum) {
  const double most = c.friction * sum.along;
  const Vector3d stopping = sum.across - c.tangents * (c.acrossMass * across);
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

/// Brings the speed along the normal up to `target`, with the sum of the impulses so far 0 or more, and
/// friction within its cone. Returns the change of the impulse.
Bearing solveContact(LinkedBodies& bodies, PairContact& c, Bearing& sum, double target) {
  const Vector3d relative = velocityAt(bodies, c.a) - velocityAt(bodies, c.b);
  const Bearing before = sum;
  sum.along = std::max(0.0, sum.along + (target - c.normal.dot(relative)) * c.mass);
  const double along = sum.along - before.along;
  addFriction(c, c.tangents.transpose() * relative + along * c.acrossAlong, sum);
  const Bearing change{along, sum.across - before.across};
  bear(bodies, c, change);
  return change;
}

double targetOf(const PairContact& c, double dt) {
  if (c.bounce > 0.0) return c.bounce;
  return c.gap >= 0.0 ? -c.gap / dt : std::min(-kRecovery * c.gap / dt, c.recoverySpeed);
}

/// Newton's law of restitution for those that would meet in this substep.
void prepareBounce(PairContact& c, const LinkedBodies& bodies, double dt) {
  c.bounce = 0.0;
  if (c.restitution == 0.0) return;
  const double approach = -c.normal.dot(velocityAt(bodies, c.a) - velocityAt(bodies, c.b));
  if (approach > kLeastBounce && c.gap < approach * dt) c.bounce = c.restitution * approach;
}

void pushJoint(LinkedBodies& bodies, JointRow& j, double impulse) {
  const auto push = [&](std::uint32_t body, const Vector3d& linear, const Vector3d& angular) {
    if (body == JointRow::kHeld) return;
    RigidState& rigid = bodies.rigids[body];
    rigid.velocity += impulse * linear.cwiseProduct(rigid.inverseMass);
    rigid.angularVelocity += impulse * (rigid.inverseInertia * angular);
  };
  push(j.a, j.linearA, j.angularA);
  push(j.b, j.linearB, j.angularB);
  j.impulse += impulse;
}

double speedOf(const LinkedBodies& bodies, const JointRow& j) {
  const auto share = [&](std::uint32_t body, const Vector3d& linear, const Vector3d& angular) {
    if (body == JointRow::kHeld) return 0.0;
    const RigidState& rigid = bodies.rigids[body];
    return linear.dot(rigid.velocity) + angular.dot(rigid.angularVelocity);
  };
  return share(j.a, j.linearA, j.angularA) + share(j.b, j.linearB, j.angularB);
}

double solveJoint(LinkedBodies& bodies, JointRow& j, double& sum) {
  const double wanted = sum + (j.speed - speedOf(bodies, j) - j.softness * sum) * j.mass;
  const double impulse = std::clamp(wanted, j.lower, j.upper), change = impulse - sum;
  sum = impulse;
  pushJoint(bodies, j, change);
  return change;
}

/// What a sweep has changed: the largest change of a velocity, and the sum of all changes as an energy.
struct Change {
  double largest = 0.0, energy = 0.0;
  void add(double squaredImpulse, double mass) {
    largest = std::max(largest, squaredImpulse / (mass * mass));
    energy += squaredImpulse / mass;
  }
  bool within(double tolerance) const { return largest <= tolerance * tolerance; }
};

/// One stage of all rows of a group.
struct Solve {
  PairRows& rows;
  LinkedBodies& bodies;
  Stage stage;
  double dt;

  bool takesPart(const PairContact& c) const {
    return c.mass > 0.0 && (stage == Stage::Stopping || c.stopping.along > 0.0);
  }

  /// What the last substep bore is about what this one will.
  void start() {
    for (JointRow& j : rows.joints) {
      pushJoint(bodies, j, impulseOf(j, stage));
      j.direction = 0.0;
    }
    for (PairContact& c : rows.contacts) {
      Bearing& sum = bearingOf(c, stage);
      if (!takesPart(c)) sum = {};
      if (sum.along > 0.0) bear(bodies, c, sum);
      c.direction = {};
    }
  }

  Change sweep() {
    Change change;
    for (JointRow& j : rows.joints) {
      j.change = j.mass > 0.0 ? solveJoint(bodies, j, impulseOf(j, stage)) : 0.0;
      if (j.mass > 0.0) change.add(j.change * j.change, j.mass);
    }
    for (PairContact& c : rows.contacts) {
      if (!takesPart(c)) continue;
      const double target = stage == Stage::Stopping ? targetOf(c, dt) : 0.0;
      c.change = solveContact(bodies, c, bearingOf(c, stage), target);
      change.add(c.change.along * c.change.along + c.change.across.squaredNorm(), c.mass);
    }
    return change;
  }

  /// On along `beta` times the last direction; the new one is that and what the sweep has changed.
  void stepOn(double beta) {
    for (JointRow& j : rows.joints) {
      j.direction *= beta;
      pushJoint(bodies, j, j.direction);
      impulseOf(j, stage) += j.direction;
      j.direction += j.change;
    }
    for (PairContact& c : rows.contacts) {
      if (!takesPart(c)) continue;
      c.direction = {beta * c.direction.along, beta * c.direction.across};
      bear(bodies, c, c.direction);
      Bearing& sum = bearingOf(c, stage);
      sum = {sum.along + c.direction.along, sum.across + c.direction.across};
      c.direction = {c.direction.along + c.change.along, c.direction.across + c.change.across};
    }
  }

  int run() {
    start();
    double before = 0.0;
    for (int count = 1;; ++count) {
      const Change change = sweep();
      if (change.within(kPairTolerance) || count == kMostSweeps) return count;
      // where the last sweep has changed more than the one before, its direction leads astray
      const double beta = before > 0.0 ? change.energy / before : 0.0;
      stepOn(beta <= 1.0 ? beta : 0.0);
      before = change.energy;
    }
  }
};

void prepareContact(PairContact& c, const LinkedBodies& bodies) {
  const Matrix3d m = mobility(bodies, c.a) + mobility(bodies, c.b);
  const double along = c.normal.dot(m * c.normal);
  c.mass = along > 0.0 ? 1.0 / along : 0.0;
  c.tangents.col(0) = c.normal.unitOrthogonal();
  c.tangents.col(1) = c.normal.cross(c.tangents.col(0));
  c.acrossAlong = c.tangents.transpose() * m * c.normal;
  const Eigen::Matrix2d across = c.tangents.transpose() * m * c.tangents;
  c.acrossMass = across.determinant() > 0.0 ? Eigen::Matrix2d(across.inverse()) : Eigen::Matrix2d::Zero();
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

}  // namespace

void preparePairs(PairRows& rows, const LinkedBodies& bodies) {
  for (PairContact& c : rows.contacts) prepareContact(c, bodies);
  for (JointRow& j : rows.joints) prepareJoint(j, bodies);
}

int stopPairs(PairRows& rows, LinkedBodies& bodies, double dt) {
  for (PairContact& c : rows.contacts) prepareBounce(c, bodies, dt);
  return Solve{rows, bodies, Stage::Stopping, dt}.run();
}

void movePairs(PairRows& rows, const LinkedBodies& bodies, double dt) {
  for (PairContact& c : rows.contacts)
    c.gap += dt * c.normal.dot(velocityAt(bodies, c.a) - velocityAt(bodies, c.b));
}

int settlePairs(PairRows& rows, LinkedBodies& bodies) {
  return Solve{rows, bodies, Stage::Settling, 0.0}.run();
}

}  // namespace limber
