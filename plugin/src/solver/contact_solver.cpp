// SPDX-License-Identifier: Zlib
// Solves the contacts, joints and anchors of an island together, by sweeps over their rows.
#include "solver/contact_row.h"

namespace limber {
namespace {

using Eigen::Vector3d;
using ConstMap = Eigen::Map<const Vector3d>;

// --- sweeps ------------------------------------------------------------------------------------------------

/// Few solves need more than a tenth of this number. A lower limit costs more: the remaining error slows down
/// the solves of all following substeps.
constexpr int kMaxSweeps = 50;

/// The one of a row's two impulses that a solve changes.
enum class Stage { Positions, Velocities };

/// m/s, replaces IslandConstraints::tolerance if there are only anchors, which hold to rounding.
constexpr double kTightTolerance = 1e-10;

/// Number of sweeps in which friction cones follow the normal impulses and friction has a least change. These
/// sweeps may cycle for ever: cones that follow are no convex problem, and a friction that turns never
/// reverses. Without both, they converge to the minimum of a convex energy. But cones that are fixed too
/// early belong to an unfinished solve, which depends on the order of contacts.
constexpr int kFreeSweeps = 15;

/// After this number of sweeps, by which few contacts have converged, a solve of velocities ends with changes
/// that are larger than the tolerance by a factor. No body moves by the rest: the positions of the next
/// substep are solved to the tolerance. A pile of 200 bodies needs half as many sweeps of velocities.
constexpr int kExactSweeps = 6;
constexpr double kLargerTolerance = 10.0;

/// A solve whose sweep does this many times as much work as its first one does without directions from then
/// on. Supports that come and go, and impulses whose work is limited, are no quadratic problem: on a cloth
/// between a jelly and spikes of the ground, conjugate directions made solves diverge.
constexpr double kDiverging = 10.0;

void pushBodies(LinkedBodies& bodies, const JointConstraint& j, double impulse) {
  forEachSide(bodies.rigids, j, [&](RigidState& rigid, const Vector3d& linear, const Vector3d& angular) {
    rigid.velocity += impulse * linear.cwiseProduct(rigid.inverseMass);
    rigid.angularVelocity += impulse * (rigid.inverseInertia * angular);
  });
}

void applyImpulse(LinkedBodies& bodies, JointConstraint& j, double change) {
  pushBodies(bodies, j, change);
  j.impulse += change;
}

double speedOf(const LinkedBodies& bodies, const JointConstraint& j) {
  double speed = 0.0;
  forEachSide(bodies.rigids, j,
              [&](const RigidState& rigid, const Vector3d& linear, const Vector3d& angular) {
                speed += linear.dot(rigid.velocity) + angular.dot(rigid.angularVelocity);
              });
  return speed;
}

/// Like kSoftness, of the joints' block. A taut chain of joints has no other compliance across it: without
/// any, it would vibrate for ever. A pivot that bears the weight of a body is off by
///     (1 - kKept) kBlockSoftness g h^2 / (2 n erp),
/// 1.4e-6 m / n in ticks of h = 1/60 s with n substeps and Bullet's erp of 0.2.
constexpr double kBlockSoftness = 1e-3;

/// Returns the speed that the row lacks.
double lackOf(const LinkedBodies& bodies, const JointConstraint& j, Stage stage) {
  const double correction = stage == Stage::Velocities ? j.correction : 0.0;
  return j.speed - correction - j.curve - speedOf(bodies, j);
}

/// Likewise, with the impulse `sum` to which the row yields.
double errorOf(const LinkedBodies& bodies, const JointConstraint& j, Stage stage, double softness,
               double sum) {
  const double yielding = softness * (sum - kKept * j.before) / j.mass;
  return lackOf(bodies, j, stage) - j.softness * sum - yielding;
}

/// Changes the impulse `sum` within its limits so that the joint has its speed. Sets j.change to the change.
void solveJoint(LinkedBodies& bodies, JointConstraint& j, Stage stage, double softness, double& sum) {
  const double target = sum + errorOf(bodies, j, stage, softness, sum) * j.mass / (1.0 + softness);
  const double impulse = std::clamp(target, j.lower, j.upper);
  j.change = impulse - sum;
  sum = impulse;
  applyImpulse(bodies, j, j.change);
}

/// 1/kg, of the contact's point on the rigid body, along the axis in which it is largest.
double largestMobility(const ConstraintRotation& r) {
  double largest = 0.0;
  for (int k = 0; k < 3; ++k) largest = std::max(largest, ConstMap(r.speeds[k]).dot(ConstMap(r.response[k])));
  return r.body->inverseMass.maxCoeff() * r.inverseFactor + largest;
}

/// The contacts of a row's points with static or kinematic objects, opposite to the row.
///
/// A light point between a heavy body and the floor takes up only a share of m / M of the body's impulse in a
/// sweep. So a change of the row's impulse along the normal is passed on to the support at once: the point
/// keeps its speed along the support's normal, and the row's mobility is
///     K = K_rr - K_rs^2 / K_ss,
/// nearly that of the heavy body alone, with the speed K_xy at x per impulse at y.
struct Supports {
  double mobility;  ///< 1/kg, K
  std::size_t count = 0;
  std::array<std::uint32_t, 6> rows{};
  std::array<double, 6> ratios{};  ///< impulse that is passed on per impulse of the row
};

/// Least K / K_rr: a point between two heavy objects that cannot move.
constexpr double kLeastMobility = 1e-9;

/// One stage of all rows of an island. Contacts without an impulse that are not violated either are left out
/// of the sweeps, and tested again after these.
///
/// In a pile most contacts are solved after a few sweeps, and a few groups of them need many. So a sweep
/// leaves out the contacts whose point masses and rigid bodies no contact has changed by more than the
/// tolerance since the last sweep. The solve ends with a sweep over all. With joints and anchors, which act
/// through many bodies at once, every sweep is over all.
struct Solve {
  IslandConstraints& rows;
  LinkedBodies& bodies;
  Team& team;
  Stage stage;
  double dt = 0.0;         ///< s, of the drift after which anchors coincide; 0 for velocities
  double tick = 0.0;       ///< s, likewise 0
  double tolerance = 0.0;  ///< m/s, of the present sweep
  int count = 0;           ///< number of the present sweep, from 1 on

  template <class Row>
  auto& impulse(Row& row) const {
    return stage == Stage::Positions ? row.positionImpulse : row.velocityImpulse;
  }
  void apply(ContactConstraint& row, const ContactVector& change) const {
    applyImpulse(rows, row, change);
    if (rows.rowNodes[static_cast<std::size_t>(&row - rows.rows.data())].isSupported)
      passOn(supportsOf(row), change.n);
  }
  void apply(JointConstraint& j, double change) const { applyImpulse(bodies, j, change); }
  void apply(LinkAnchor& anchor, const Vector3d& change) const {
    limber::applyImpulse(bodies, anchor, change);
  }

  /// Returns the supports of a row that have an impulse.
  Supports supportsOf(const ContactConstraint& row) const {
    Supports found{row.mobility};
    for (std::uint32_t p = row.firstPoint; p < row.endPoint; ++p) {
      const std::uint32_t i = rows.supportOf[p];
      if (i == ConstraintNode::kNoSupport || !rows.rowNodes[i].isActive || !(impulse(rows.rows[i]).n > 0.0))
        continue;
      found.mobility += rows.supported[p].mobility;
      found.rows[found.count] = i, found.ratios[found.count++] = rows.supported[p].ratio;
    }
    return found;
  }

  /// Sets `supported` of a row's points. They change with the row's contact points, and with its axes and
  /// those of its supports, which none but following rows have.
  void setSupported(std::uint32_t i) const {
    RowNodes& of = rows.rowNodes[i];
    if (std::exchange(of.knowsSupports, rows.following.empty())) return;
    const ContactConstraint& row = rows.rows[i];
    for (std::uint32_t p = row.firstPoint; p < row.endPoint; ++p) {
      if (rows.supportOf[p] == ConstraintNode::kNoSupport) continue;
      const ContactConstraint& support = rows.rows[rows.supportOf[p]];
      const ConstraintPoint &above = rows.points[p], &below = rows.points[support.firstPoint];
      double ofSupport = 0.0, ofRow = 0.0;
      for (int k = 0; k < 3; ++k) {
        const double axes = row.axes[0][k] * support.axes[0][k];
        ofSupport += below.share * above.response[k] * axes;
        ofRow += above.share * below.response[k] * axes;
      }
      const double ratio = -ofSupport * support.mass;
      rows.supported[p] = {ratio, ratio * ofRow};
    }
  }

  /// Adds to the supports' impulses what keeps their speeds when a row's impulse changes along the normal.
  void passOn(const Supports& supports, double change) const {
    for (std::size_t k = 0; k < supports.count; ++k) {
      ContactConstraint& support = rows.rows[supports.rows[k]];
      const double added = supports.ratios[k] * change;
      applyNormalImpulse(rows, support, added);
      impulse(support).n += added;
    }
  }

  bool canPassOn(const ContactConstraint& row, const Supports& supports, double change) const {
    for (std::size_t k = 0; k < supports.count; ++k)
      if (impulse(rows.rows[supports.rows[k]]).n + supports.ratios[k] * change < 0.0) return false;
    return supports.count > 0 && supports.mobility > kLeastMobility * row.mobility;
  }

  /// Solves a contact together with the supports of its points. Returns the mobility along the normal (1/kg).
  double solveSupported(ContactConstraint& row, bool free) const {
    const Supports supports = supportsOf(row);
    ContactVector& total = impulse(row);
    const double mass = 1.0 / supports.mobility, softness = row.softness * row.mobility * mass;
    const double n = normalImpulse(row, mass, softness, total.n, speedAlong(rows, row));
    const double change = n - total.n;
    if (!canPassOn(row, supports, change)) {
      solveContact(rows, row, total, free);
      return row.mobility;
    }
    applyImpulse(rows, row, {change, 0.0, 0.0});
    passOn(supports, change);
    ContactVector sum = {n, total.u, total.v};
    if (free) row.maxFriction = row.friction * n;
    const ContactVector speeds = speedsOf(rows, row);
    const bool forced = addFriction(row, speeds.u, speeds.v, free ? row.minFrictionChange : 0.0,
                                    kSlowSliding * rows.tolerance, sum);
    applyImpulse(rows, row, {0.0, sum.u - total.u, sum.v - total.v});
    noteReversal(row, {change, sum.u - total.u, sum.v - total.v}, forced);
    total = sum;
    return supports.mobility;
  }

  template <class Visit>
  void forEachSet(Visit visit) const {
    limber::forEachSet(rows, team, visit);
  }

  /// Calls visit(i, row) for the active rows of a set.
  template <class Visit>
  void forEachActive(const RowSet& set, Visit visit) const {
    for (std::uint32_t k = set.begin; k < set.begin + set.activeCount; ++k)
      visit(rows.active[k], rows.rows[rows.active[k]]);
  }

  void markChanged(std::uint32_t i) const {
    rows.changedIn[rows.rowNodes[i].a] = rows.changedIn[rows.rowNodes[i].b] = count;
    for (std::uint32_t p = rows.rowNodes[i].begin; p < rows.rowNodes[i].end; ++p)
      rows.nodes[rows.nodeOf[p]] = {count, 0.0};
  }

  void activate(RowSet& set, std::uint32_t i) const {
    alignContactPoints(rows, i);
    ContactConstraint& row = rows.rows[i];
    rows.rowNodes[i].isActive = true;
    if (rows.rowNodes[i].isSupported) setSupported(i);
    row.maxFriction = 0.0;
    row.minFrictionChange = kMinFrictionChange;
    row.direction = ContactVector();
    row.change = ContactVector();
    rows.rowNodes[i].isLeftOut = false;
    markChanged(i);
    rows.active[set.begin + set.activeCount++] = i;
  }

  /// Sets the target of a row, before any row has an impulse if there are restitutions.
  void setTarget(std::size_t i) const {
    ContactConstraint& row = rows.rows[i];
    if (stage == Stage::Positions)
      limber::setTarget(rows, i, dt, tick);
    else
      row.target = row.bounces ? row.speedAfter(speedAlong(rows, row)) : 0.0;
  }

  /// Applies the impulse of the last substep as a warm start.
  void start(RowSet& set, std::uint32_t i) const {
    if (!rows.restitutes) setTarget(i);
    ContactConstraint& row = rows.rows[i];
    ContactVector& sum = impulse(row);
    const bool takesPart = row.mass > 0.0 && (stage == Stage::Positions || row.positionImpulse.n > 0.0);
    rows.rowNodes[i].isActive = false;
    if (!takesPart || sum.n <= 0.0) sum = ContactVector();
    row.before = sum;
    if (sum.n > 0.0 || (takesPart && stage == Stage::Velocities)) activate(set, i);
    if (sum.n > 0.0) applyImpulse(rows, row, sum);
  }

  void start() {
    factorBlock(rows.joints, bodies, blockSoftness(), rows.block);
    if (rows.restitutes) forEachRow(rows, team, [&](std::size_t i) { setTarget(i); });
    for (JointConstraint& j : rows.joints) {
      apply(j, impulse(j));
      j.before = impulse(j);
      j.direction = 0.0;
    }
    pushFrames(bodies);
    for (LinkAnchor& anchor : bodies.anchors) {
      apply(anchor, impulse(anchor));
      anchor.direction.setZero();
    }
    forEachSet([&](RowSet& set) {
      set.activeCount = 0;
      for (std::uint32_t i = set.begin; i < set.end; ++i) start(set, i);
    });
    if (stage == Stage::Positions) activateViolated();
  }

  std::uint32_t activeCount() const {
    std::uint32_t sum = 0;
    for (const RowSet& set : rows.sets) sum += set.activeCount;
    return sum;
  }

  /// Activates the contacts that the coming drift would violate. Returns whether there are any.
  bool activateViolated() const {
    const std::uint32_t before = activeCount();
    forEachSet([&](RowSet& set) {
      const std::uint32_t countBefore = set.activeCount;
      for (std::uint32_t i = set.begin; i < set.end; ++i) {
        if (rows.rowNodes[i].isActive) continue;
        const ContactConstraint& row = rows.rows[i];
        if (row.mass > 0.0 && speedAlong(rows, row) < row.target) activate(set, i);
      }
      const auto first = rows.active.begin() + set.begin;
      if (countBefore > 0 && set.activeCount > countBefore) std::sort(first, first + set.activeCount);
    });
    return activeCount() > before;
  }

  void restoreMinFriction() const {
    for (const RowSet& set : rows.sets)
      forEachActive(
          set, [](std::uint32_t, ContactConstraint& row) { row.minFrictionChange = kMinFrictionChange; });
  }

  /// The limits follow the contact like friction cones, see kFreeSweeps.
  void limitRolling(JointConstraint& j) const {
    j.upper = j.rolling * impulse(rows.rows[j.contact]).n;
    j.lower = -j.upper;
  }

  void markPoints(std::uint32_t i) const {
    const RowNodes& of = rows.rowNodes[i];
    rows.changedIn[of.a] = rows.changedIn[of.b] = count;
    for (std::uint32_t p = of.begin; p < of.end; ++p)
      if (rows.momentArms[p].position) rows.nodes[rows.nodeOf[p]].changedIn = count;
  }

  /// Adds a change of at most `speed` (m/s) to a rigid body of the row. Marks it once all changes since the
  /// last time are large enough.
  void noteRigidChange(const ConstraintRotation& rigid, const RowNodes& of, double speed) const {
    ConstraintNode& node = rows.nodes[rigid.node];
    node.changed += speed;
    if (!(node.changed > tolerance)) return;
    node = {count, 0.0};
    rows.changedIn[of.a] = rows.changedIn[of.b] = count;
  }

  /// Marks the row's point masses if the change is large enough. Rigid bodies are heavier, and a change that
  /// is large for a point is small for them.
  void noteChange(std::uint32_t i, const ContactVector& change) const {
    const ContactConstraint& row = rows.rows[i];
    const double squared = change.squaredNorm();
    if (squared * row.mobility * row.mobility > tolerance * tolerance) markPoints(i);
    for (std::uint32_t r = row.firstRotation; r < row.endRotation; ++r)
      noteRigidChange(rows.rotations[r], rows.rowNodes[i],
                      std::sqrt(squared) * largestMobility(rows.rotations[r]));
  }

  bool isNearChange(const RowNodes& of) const {
    if (std::max(rows.changedIn[of.a], rows.changedIn[of.b]) + 1 < count) return false;
    for (std::uint32_t p = of.begin; p < of.end; ++p)
      if (rows.nodes[rows.nodeOf[p]].changedIn + 1 >= count) return true;
    return false;
  }

  /// Returns whether the sweep leaves out the row.
  bool leavesOut(std::uint32_t i, bool all) const {
    RowNodes& of = rows.rowNodes[i];
    const bool wasLeftOut = of.isLeftOut;
    of.isLeftOut = !all && !isNearChange(of);
    if (of.isLeftOut && !wasLeftOut) rows.rows[i].change = rows.rows[i].direction = ContactVector();
    return of.isLeftOut;
  }

  bool hasOnlyContacts() const { return rows.joints.empty() && bodies.anchors.empty(); }

  double jointSoftness() const { return rows.pressed ? kSoftness : 0.0; }
  double blockSoftness() const { return rows.pressed ? kSoftness : kBlockSoftness; }

  /// Solves the rows of the block together. The changes of their speeds count: along a taut chain, large
  /// impulses change little.
  void sweepBlock(SweepChange& change) const {
    JointBlock& block = rows.block;
    for (std::size_t i = 0; i < block.rows.size(); ++i) {
      JointConstraint& j = rows.joints[block.rows[i]];
      block.change[i] = errorOf(bodies, j, stage, blockSoftness(), impulse(j));
      if (block.pivots[i] > 0.0)
        change.add(block.change[i] * block.change[i] * j.mass * j.mass, 1.0 / j.mass);
    }
    solveBlock(block);
    for (std::size_t i = 0; i < block.rows.size(); ++i) {
      JointConstraint& j = rows.joints[block.rows[i]];
      j.change = block.change[i];
      impulse(j) += j.change;
      apply(j, j.change);
    }
  }

  SweepChange sweepJoints(bool free) const {
    SweepChange change;
    fitFrameVelocities(bodies);
    sweepBlock(change);
    for (JointConstraint& j : rows.joints) {
      if (j.mass == 0.0 || j.inBlock) continue;
      if (free && j.contact != JointConstraint::kHeld) limitRolling(j);
      solveJoint(bodies, j, stage, jointSoftness(), impulse(j));
      change.add(j.change * j.change, 1.0 / j.mass);
    }
    pushFrames(bodies);
    for (const AnchorSet& set : bodies.anchorSets) {
      findChanges(bodies, set, dt);
      for (std::uint32_t k = set.begin; k < set.end; ++k) {
        LinkAnchor& anchor = bodies.anchors[bodies.anchorOrder[k]];
        apply(anchor, anchor.change);
        impulse(anchor) += anchor.change;
        change.add(anchor.error, anchor.change);
      }
    }
    return change;
  }

  /// Adds to set.change.
  void sweep(RowSet& set, bool free, bool all) const {
    SweepChange change = set.change;
    std::uint32_t swept = set.begin;
    forEachActive(set, [&](std::uint32_t i, ContactConstraint& row) {
      if (leavesOut(i, all)) return;
      rows.swept[swept++] = i;
      if (rows.rowNodes[i].isSupported) {
        const double mobility = solveSupported(row, free);
        change.add(row.change.n * row.change.n, mobility);
        change.add(row.change.u * row.change.u + row.change.v * row.change.v, row.mobility);
      } else {
        solveContact(rows, row, impulse(row), free);
        change.add(row.change.squaredNorm(), row.mobility);
      }
      noteChange(i, row.change);
    });
    set.sweptCount = swept - set.begin;
    set.change = change;
  }

  /// `free`: friction cones follow the normal impulses. `all`: leaves out no contact.
  SweepChange sweep(bool free, bool all) const {
    for (RowSet& set : rows.sets) set.change = SweepChange();
    rows.sets[0].change = sweepJoints(free);
    forEachSet([&](RowSet& set) { sweep(set, free, all); });
    SweepChange change;
    for (const RowSet& set : rows.sets) change.add(set.change);
    return change;
  }

  bool wasWhole() const {
    return std::all_of(rows.sets.begin(), rows.sets.end(),
                       [](const RowSet& set) { return set.sweptCount == set.activeCount; });
  }

  /// Makes a conjugate gradient step of `beta` times the last direction. The new direction is this step plus
  /// the change of the sweep.
  template <class Row>
  void stepAlongDirection(Row& row, double beta) const {
    row.direction *= beta;
    if (beta > 0.0) {
      apply(row, row.direction);
      impulse(row) += row.direction;
    }
    row.direction += row.change;
  }

  void stepAlongDirections(double beta) const {
    for (JointConstraint& j : rows.joints) stepAlongDirection(j, beta);
    pushFrames(bodies);
    for (LinkAnchor& anchor : bodies.anchors) stepAlongDirection(anchor, beta);
    forEachSet([&](RowSet& set) {
      for (std::uint32_t k = set.begin; k < set.begin + set.sweptCount; ++k) {
        ContactConstraint& row = rows.rows[rows.swept[k]];
        stepAlongDirection(row, beta);
        noteChange(rows.swept[k], row.direction);
      }
    });
  }

  bool hasNothingToDo() const { return hasOnlyContacts() && activeCount() == 0; }

  /// Ends an unfinished solve: errors remain between bodies, but no point goes into a static object.
  void holdPoints() const {
    if (stage == Stage::Positions) activateViolated();
    forEachSet([&](RowSet& set) {
      forEachActive(set, [&](std::uint32_t i, ContactConstraint& row) {
        if (isOfPoint(contactOf(rows, i))) solveContact(rows, row, impulse(row), false);
      });
    });
  }

  int run() {
    std::fill(rows.changedIn.begin(), rows.changedIn.end(), 0);
    std::fill(rows.nodes.begin(), rows.nodes.end(), ConstraintNode());
    start();
    tolerance = rows.empty() ? kTightTolerance : rows.tolerance;
    double before = 0.0, most = 0.0;  // J, of a sweep
    int lastFree = kFreeSweeps;
    bool all = true, diverges = false;
    for (count = 1; !hasNothingToDo(); ++count) {
      if (stage == Stage::Velocities && count == kExactSweeps) tolerance *= kLargerTolerance;
      const SweepChange change = sweep(count <= lastFree, all);
      if (count == kMaxSweeps) {
        holdPoints();
        return count;
      }
      const bool converged = change.within(tolerance), whole = wasWhole();
      all = !hasOnlyContacts() || (converged && !whole);
      const bool ends = converged && whole;
      if (ends && (stage == Stage::Velocities || !activateViolated())) return count;
      if (most == 0.0) most = kDiverging * change.energy;
      diverges = diverges || change.energy > most;
      if (ends) lastFree = count + kFreeSweeps, most = 0.0, restoreMinFriction();
      // restart the directions where the last sweep has changed more than the one before
      const double beta = before > 0.0 ? change.energy / before : 0.0;
      stepAlongDirections(beta <= 1.0 && !diverges ? beta : 0.0);
      before = change.energy;
    }
    return 0;
  }
};

/// Updates the responses of rigid bodies to their present rotation. Returns false if there is nothing to
/// solve.
bool startSolve(IslandConstraints& rows, LinkedBodies& bodies) {
  for (ConstraintRotation& rotation : rows.rotations)
    for (int k = 0; k < 3; ++k)
      Eigen::Map<Vector3d>(rotation.response[k]) =
          rotation.inverseFactor * (rotation.body->inverseInertia * ConstMap(rotation.speeds[k]));
  updateAnchors(bodies);
  return !rows.empty() || !bodies.anchors.empty();
}

/// Whether the row has a speed that it must have, or one that it must not pass.
bool mustHold(const JointConstraint& j) {
  return j.contact == JointConstraint::kHeld && j.mass > 0.0 && !j.isDriven;
}

/// Adds the work by which the rows have corrected errors. Where they contradict each other, large impulses
/// correct nothing.
void addWork(IslandConstraints& rows, LinkedBodies& bodies, Stage stage) {
  fitFrameVelocities(bodies);
  for (JointConstraint& j : rows.joints) {
    if (j.isDriven || j.contact != JointConstraint::kHeld) continue;
    const double impulse = stage == Stage::Positions ? j.positionImpulse : j.velocityImpulse;
    const double recovery = j.recovery - (stage == Stage::Velocities ? j.correction : 0.0);
    j.work += impulse * (recovery - lackOf(bodies, j, stage));
  }
}

}  // namespace

void holdJoints(IslandConstraints& rows, LinkedBodies& bodies) {
  turnJoints(rows, bodies, 0.0, JointPivots::Own);
  for (JointConstraint& j : rows.joints) j.direction = 0.0;
  JointBlock& block = rows.block;
  factorBlock(rows.joints, bodies, kBlockSoftness, block);
  double largest = HUGE_VAL;
  for (int sweep = 0; sweep < kMaxSweeps && largest > rows.tolerance; ++sweep) {
    largest = 0.0;
    const auto lacks = [&](const JointConstraint& j) { return j.speed - speedOf(bodies, j); };
    for (std::size_t i = 0; i < block.rows.size(); ++i) {
      block.change[i] = lacks(rows.joints[block.rows[i]]);
      largest = std::max(largest, std::abs(block.change[i]));
    }
    solveBlock(block);
    for (std::size_t i = 0; i < block.rows.size(); ++i)
      pushBodies(bodies, rows.joints[block.rows[i]], block.change[i]);
    for (JointConstraint& j : rows.joints) {
      if (!mustHold(j) || j.inBlock) continue;
      const double target = j.direction + lacks(j) * j.mass;
      const double change = std::clamp(target, j.lower, j.upper) - j.direction;
      pushBodies(bodies, j, change);
      j.direction += change;
      largest = std::max(largest, std::abs(change) / j.mass);
    }
  }
}

int solvePositions(IslandConstraints& rows, LinkedBodies& bodies, Team& team, double dt, double tick) {
  if (!startSolve(rows, bodies)) return 0;
  aimAnchors(bodies, dt, tick);
  const int sweeps = Solve{rows, bodies, team, Stage::Positions, dt, tick}.run();
  addWork(rows, bodies, Stage::Positions);
  return sweeps;
}

int solveVelocities(IslandConstraints& rows, LinkedBodies& bodies, Team& team) {
  if (!startSolve(rows, bodies)) return 0;
  const int sweeps = Solve{rows, bodies, team, Stage::Velocities}.run();
  addWork(rows, bodies, Stage::Velocities);
  if (!rows.restitutes) return sweeps;
  forEachRow(rows, team, [&](std::size_t i) {
    if (rows.rows[i].restitutes) keepVelocity(rows, rows.rows[i]);
  });
  return sweeps;
}

}  // namespace limber
