// SPDX-License-Identifier: Zlib
#include "core/pair_solve.h"

#include <algorithm>
#include <cmath>

namespace limber {
namespace {

/// As in contact_rows.cpp.
constexpr double kRecovery = 0.2;

/// Few solves need more than a tenth of it, but to end those early costs more: the error that is left is in
/// the way of all substeps that follow.
constexpr int kMostSweeps = 50;

/// Which of a row's two impulses a solve is about.
enum class Stage { Stopping, Settling };

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

/// What a sweep has changed: the largest change of a velocity, squared, and the sum of all as an energy.
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

  Bearing& bearing(PairContact& c) const { return stage == Stage::Stopping ? c.stopping : c.settling; }
  double& impulse(JointRow& j) const { return stage == Stage::Stopping ? j.stopping : j.settling; }
  bool takesPart(const PairContact& c) const {
    return c.mass > 0.0 && (stage == Stage::Stopping || c.stopping.along > 0.0);
  }

  /// What the last substep bore is about what this one will.
  void start() {
    for (JointRow& j : rows.joints) {
      bear(bodies, j, impulse(j));
      j.direction = 0.0;
    }
    for (PairContact& c : rows.contacts) {
      Bearing& sum = bearing(c);
      if (!takesPart(c)) sum = Bearing();
      if (sum.along > 0.0) bear(bodies, c, sum);
      c.before = sum;
      c.direction = Bearing();
    }
  }

  Change sweep() {
    Change change;
    for (JointRow& j : rows.joints) {
      if (j.mass == 0.0) continue;
      solveJoint(bodies, j, impulse(j));
      change.add(j.change * j.change, j.mass);
    }
    for (PairContact& c : rows.contacts) {
      if (!takesPart(c)) continue;
      solveContact(bodies, c, bearing(c), stage == Stage::Stopping ? targetOf(c, dt) : 0.0);
      change.add(c.change.along * c.change.along + c.change.across.squaredNorm(), c.mass);
    }
    return change;
  }

  /// On along `beta` times the last direction; the new one is that and what the sweep has changed.
  void stepOn(double beta) {
    for (JointRow& j : rows.joints) {
      j.direction *= beta;
      bear(bodies, j, j.direction);
      impulse(j) += j.direction;
      j.direction += j.change;
    }
    for (PairContact& c : rows.contacts) {
      if (!takesPart(c)) continue;
      c.direction *= beta;
      bear(bodies, c, c.direction);
      bearing(c) += c.direction;
      c.direction += c.change;
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

}  // namespace

int stopPairs(PairRows& rows, LinkedBodies& bodies, double dt) {
  if (rows.empty()) return 0;
  for (PairContact& c : rows.contacts) prepareBounce(c, bodies, dt);
  return Solve{rows, bodies, Stage::Stopping, dt}.run();
}

int settlePairs(PairRows& rows, LinkedBodies& bodies) {
  if (rows.empty()) return 0;
  return Solve{rows, bodies, Stage::Settling, 0.0}.run();
}

}  // namespace limber
