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

/// m/s that the contact needs before a drift. What would meet in this substep parts by Newton's law of
/// restitution.
double targetOf(const PairRows& rows, const PairContact& c, const PairRow& row, double dt) {
  if (c.restitution > 0.0) {
    const double approach = -speedAlong(rows, row);
    if (approach > kLeastBounce && row.gap < approach * dt) return c.restitution * approach;
  }
  return row.gap >= 0.0 ? -row.gap / dt : std::min(-kRecovery * row.gap / dt, c.recoverySpeed);
}

/// What a sweep has changed: the largest change of a velocity, squared, and the sum of all as an energy.
struct Change {
  double largest = 0.0, energy = 0.0;
  void add(double squaredImpulse, double mobility) {
    const double work = squaredImpulse * mobility;
    largest = std::max(largest, work * mobility);
    energy += work;
  }
  bool within(double tolerance) const { return largest <= tolerance * tolerance; }
};

/// One stage of all rows of a group. Contacts that bear nothing and are not crossed either are left out of
/// the sweeps, and looked at again when these have ended.
struct Solve {
  PairRows& rows;
  LinkedBodies& bodies;
  Stage stage;

  Eigen::Vector3d& impulse(PairRow& row) const {
    return stage == Stage::Stopping ? row.stopping : row.settling;
  }
  double& impulse(JointRow& j) const { return stage == Stage::Stopping ? j.stopping : j.settling; }

  void activate(std::uint32_t i) {
    PairRow& row = rows.rows[i];
    row.active = true;
    row.direction.setZero();
    row.change.setZero();
    rows.active.push_back(i);
  }

  /// What the last substep bore is about what this one will.
  void start() {
    for (JointRow& j : rows.joints) {
      bear(bodies, j, impulse(j));
      j.direction = 0.0;
    }
    rows.active.clear();
    for (std::uint32_t i = 0; i < rows.rows.size(); ++i) {
      PairRow& row = rows.rows[i];
      Eigen::Vector3d& sum = impulse(row);
      const bool takesPart = row.mass > 0.0 && (stage == Stage::Stopping || row.stopping[0] > 0.0);
      row.active = false;
      if (!takesPart || sum[0] <= 0.0) sum.setZero();
      row.before = sum;
      if (sum[0] > 0.0) bear(rows, row, sum);
      if (sum[0] > 0.0 || (takesPart && stage == Stage::Settling)) activate(i);
    }
    if (stage == Stage::Stopping) activateCrossed();
  }

  /// Takes in the contacts that would be crossed in the coming drift. Returns whether there are any.
  bool activateCrossed() {
    const std::size_t count = rows.active.size();
    for (std::uint32_t i = 0; i < rows.rows.size(); ++i) {
      const PairRow& row = rows.rows[i];
      if (!row.active && row.mass > 0.0 && speedAlong(rows, row) < row.target) activate(i);
    }
    if (rows.active.size() == count) return false;
    std::sort(rows.active.begin(), rows.active.end());
    return true;
  }

  Change sweep() {
    Change change;
    for (JointRow& j : rows.joints) {
      if (j.mass == 0.0) continue;
      solveJoint(bodies, j, impulse(j));
      change.add(j.change * j.change, 1.0 / j.mass);
    }
    for (const std::uint32_t i : rows.active) {
      PairRow& row = rows.rows[i];
      solveContact(rows, row, impulse(row), stage == Stage::Stopping ? row.target : 0.0);
      change.add(row.change.squaredNorm(), row.mobility);
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
    for (const std::uint32_t i : rows.active) {
      PairRow& row = rows.rows[i];
      row.direction *= beta;
      bear(rows, row, row.direction);
      impulse(row) += row.direction;
      row.direction += row.change;
    }
  }

  bool hasNothingToDo() const { return rows.active.empty() && rows.joints.empty(); }

  int run() {
    start();
    double before = 0.0;
    for (int count = 1; !hasNothingToDo(); ++count) {
      const Change change = sweep();
      if (count == kMostSweeps) return count;
      const bool ends = change.within(kPairTolerance);
      if (ends && (stage == Stage::Settling || !activateCrossed())) return count;
      // where the last sweep has changed more than the one before, its direction leads astray
      const double beta = before > 0.0 ? change.energy / before : 0.0;
      stepOn(beta <= 1.0 ? beta : 0.0);
      before = change.energy;
    }
    return 0;
  }
};

}  // namespace

int stopPairs(PairRows& rows, LinkedBodies& bodies, double dt) {
  if (rows.empty()) return 0;
  turnResponses(rows);
  for (std::size_t i = 0; i < rows.rows.size(); ++i)
    rows.rows[i].target = targetOf(rows, rows.contacts[i], rows.rows[i], dt);
  return Solve{rows, bodies, Stage::Stopping}.run();
}

int settlePairs(PairRows& rows, LinkedBodies& bodies) {
  if (rows.empty()) return 0;
  turnResponses(rows);
  return Solve{rows, bodies, Stage::Settling}.run();
}

}  // namespace limber
