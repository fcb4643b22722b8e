// SPDX-License-Identifier: Zlib
// Solves the contacts, joints and anchors of an island together, by sweeps over their rows.
#include "solver/contacts.h"

#include "solver/plane_contacts.h"

#include <algorithm>
#include <cmath>

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

/// Softness of contacts (a proximal term): a contact yields to the change of its impulse since the last
/// substep by this share of the yield without other contacts, and along the normal also to 1 - kKept of the
/// impulse itself. Contact impulses of rigid bodies against each other are not unique; with this term they
/// converge instead of drifting, and piles come to rest. In a pile of ten boxes it costs 3e-5 m of height. A
/// single point on a static or kinematic object needs no softness: its springs determine its impulse.
constexpr double kSoftness = 0.02;
constexpr double kKept = 0.8;

/// A contact that removes an overlap may push against a body that cannot move away: one that anchors
/// hold, or the folds of a soft body around an object. There each overlap that is removed makes another
/// one, and the energy would grow without limit. So the work of a contact in a tick is at most this
/// multiple of m v^2, less in islands with anchors, with the row's mass and either the speed at which
/// overlaps are removed or, if that is larger, the mean square of the velocities in the island: a fast
/// hit makes overlaps, since its contacts are found late, and energy that is missing until they are
/// removed. A contact with an impulse above m v may do less work, in proportion: contacts that push
/// against each other have impulses of any size.
constexpr double kRecoveryWork = 2.4, kAnchoredWork = 0.3;

/// Share of the recovery speed up to which the work is not limited. Under a heavy body points of a gram could
/// else not remove the small overlaps that every solve leaves, and a ball on a cloth would not come to rest.
constexpr double kFreeRecovery = 0.01;

/// Least change of the friction of a sliding contact in a sweep, as a share of its limit, towards the
/// direction against the sliding. The frictions of several contacts of one body may cancel each other and
/// only use up their cones. Without this minimum, slow sliding would remove them slowly. Where it makes a
/// friction go back against its change in the sweep before, it was too large and becomes smaller by a factor:
/// else the sweeps would step to and fro across the solution until the cones are fixed (see kFreeSweeps).
/// For sliding slower than kSlowSliding times the tolerance it is smaller in proportion: such sliding is
/// hardly more than the error that the solve may leave. A pile of 200 bodies at rest needs two fifths fewer
/// sweeps.
constexpr double kMinFrictionChange = 0.1;
constexpr double kAfterReversal = 0.3;
constexpr double kSlowSliding = 3.0;

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

/// Changes the friction to the one that stops the sliding (u, v) (m/s). If that is outside the cone, makes a
/// projected gradient step towards the least energy of the row alone, of at least `minChange` of the limit,
/// or less for sliding below `slow` (m/s). Returns whether this minimum has made the step longer.
inline bool addFriction(const ContactConstraint& row, double u, double v, double minChange, double slow,
                        ContactVector& sum) {
  const double* m = row.acrossMass;
  const double limit = row.maxFriction;
  u += row.acrossSoftness * (sum.u - row.before.u);
  v += row.acrossSoftness * (sum.v - row.before.v);
  const double stopU = sum.u - (m[0] * u + m[1] * v);
  const double stopV = sum.v - (m[1] * u + m[2] * v);
  if (stopU * stopU + stopV * stopV <= limit * limit) {
    sum.u = stopU, sum.v = stopV;
    return false;
  }
  const double least = minChange * limit / std::max(std::sqrt(u * u + v * v), slow);
  const double mass = std::max(row.slidingMass, least);
  sum.u -= mass * u, sum.v -= mass * v;
  const double factor = coneFactor(sum.u * sum.u + sum.v * sum.v, limit);
  sum.u *= factor, sum.v *= factor;
  return least > row.slidingMass;
}

/// Returns the impulse, 0 or more, that changes the speed along the normal from `speed` to `target` (m/s),
/// with the row's softness. `sum` (N s) is the present impulse. If its work would be more than maxWork, the
/// result n is smaller: with the impulse n0 for speed 0,
///     n (n - n0) / m = maxWork,
/// or, if that is larger, the impulse for freeSpeed. `mass` (kg) and `softness` are the row's,
/// unless it is supported.
inline double normalImpulse(const ContactConstraint& row, double mass, double softness, double sum,
                            double target, double speed) {
  const double yielding = softness * (sum - kKept * row.before.n);
  const auto impulseFor = [&](double wanted) {
    return std::max(0.0, sum + ((wanted - speed) * mass - yielding) / (1.0 + softness));
  };
  const double n = impulseFor(target), atRest = sum - speed * mass;
  if (!(n * (n - atRest) > mass * row.maxWork)) return n;
  const double limited = 0.5 * (atRest + std::sqrt(atRest * atRest + 4.0 * mass * row.maxWork));
  return std::max(limited, impulseFor(std::min(target, row.freeSpeed)));
}

/// Sets row.change. `forced`: the minimum of addFriction() has made the step longer.
inline void noteReversal(ContactConstraint& row, const ContactVector& change, bool forced) {
  if (forced && change.u * row.change.u + change.v * row.change.v < 0.0)
    row.minFrictionChange *= kAfterReversal;
  row.change = change;
}

/// Brings the speed along the normal to `target` (m/s) with the impulse `total`, which is 0 or more along the
/// normal, with friction within its cone. `free`: the cone follows the normal impulse. Sets row.change.
inline void solveContact(IslandConstraints& rows, ContactConstraint& row, ContactVector& total, double target,
                         bool free) {
  const ContactVector speeds = speedsOf(rows, row), earlier = total;
  ContactVector sum = earlier;
  sum.n = normalImpulse(row, row.mass, row.softness, sum.n, target, speeds.n);
  const double normalChange = sum.n - earlier.n;
  if (free) row.maxFriction = row.friction * sum.n;
  const bool forced = addFriction(row, speeds.u + normalChange * row.acrossAlong[0],
                                  speeds.v + normalChange * row.acrossAlong[1],
                                  free ? row.minFrictionChange : 0.0, kSlowSliding * rows.tolerance, sum);
  const ContactVector change{normalChange, sum.u - earlier.u, sum.v - earlier.v};
  applyImpulse(rows, row, change);
  noteReversal(row, change, forced);
  total = sum;
}

void applyImpulse(LinkedBodies& bodies, JointConstraint& j, double change) {
  forEachSide(bodies.rigids, j, [&](RigidState& rigid, const Vector3d& linear, const Vector3d& angular) {
    rigid.velocity += change * linear.cwiseProduct(rigid.inverseMass);
    rigid.angularVelocity += change * (rigid.inverseInertia * angular);
  });
  j.impulse += change;
}

/// Changes the impulse `sum` within its limits so that the joint has its speed. Sets j.change to the change.
void solveJoint(LinkedBodies& bodies, JointConstraint& j, double& sum) {
  double speed = 0.0;
  forEachSide(bodies.rigids, j,
              [&](const RigidState& rigid, const Vector3d& linear, const Vector3d& angular) {
                speed += linear.dot(rigid.velocity) + angular.dot(rigid.angularVelocity);
              });
  const double target = sum + (j.speed - speed - j.softness * sum) * j.mass;
  const double impulse = std::clamp(target, j.lower, j.upper);
  j.change = impulse - sum;
  sum = impulse;
  applyImpulse(bodies, j, j.change);
}

bool isSoft(const ContactPoint& p) { return p.kind == ContactPoint::Kind::Soft; }

/// 1/kg, of the contact's point on the rigid body, along the axis in which it is largest.
double largestMobility(const ConstraintRotation& r) {
  double largest = 0.0;
  for (int k = 0; k < 3; ++k) largest = std::max(largest, ConstMap(r.speeds[k]).dot(ConstMap(r.response[k])));
  return r.body->inverseMass.maxCoeff() * r.inverseFactor + largest;
}

/// Returns the largest work (J) of a contact in a substep of `share` of the tick that removes an overlap.
/// There is no limit where nothing soft or anchored yields.
double maxRecoveryWork(const IslandConstraints& rows, const Contact& c, const ContactConstraint& row,
                       bool anchored, double share) {
  if (!(row.target > 0.0) || isOfPoint(c)) return HUGE_VAL;
  if (!anchored && !isSoft(c.a) && !isSoft(c.b)) return HUGE_VAL;
  const double squaredSpeed = std::max(c.recoverySpeed * c.recoverySpeed, rows.squaredMotion);
  const double work = (anchored ? kAnchoredWork : kRecoveryWork) * share * row.mass * squaredSpeed;
  const double load = share * row.mass * std::sqrt(squaredSpeed), impulse = row.positionImpulse.n;
  return impulse > load ? work * load / impulse : work;
}

/// Sets the target speed of the contact before a drift of dt seconds. A bounce has no softness.
void setTarget(const IslandConstraints& rows, const Contact& c, ContactConstraint& row, bool anchored,
               double dt, double tick) {
  row.softness = isOfPoint(c) ? 0.0 : kSoftness;
  row.target = minSpeed(row.gap, c.recoverySpeed, dt);
  row.freeSpeed = kFreeRecovery * c.recoverySpeed;
  row.maxWork = maxRecoveryWork(rows, c, row, anchored, dt / tick);
  row.bounces = false;
  if (!(c.restitution > 0.0)) return;
  const double approach = -speedAlong(rows, row);
  const double before = -along(row.axes[0], {row.lastVelocity[0], row.lastVelocity[1], row.lastVelocity[2]});
  addBounce(row, c, row.gap, approach, before, dt);
  if (row.bounces) row.softness = 0.0, row.maxWork = HUGE_VAL;
}

/// The contacts of a row's points with static or kinematic objects, opposite to the row.
///
/// A light point between a heavy body and the floor takes up only a share of m / M of the body's impulse in a
/// sweep. So a change of the row's impulse along the normal is passed on to the support at once: the point
/// keeps its speed along the support's normal, and the row's mobility is
///     K = K_rr - K_rs^2 / K_ss,
/// nearly that of the heavy body alone, with the speed K_xy at x per impulse at y.
struct Supports {
  double unsupported;             ///< 1/kg, K_rr
  double mobility = unsupported;  ///< 1/kg, K
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
      if (i == ConstraintNode::kNoSupport || !rows.rows[i].active || !(impulse(rows.rows[i]).n > 0.0))
        continue;
      const ContactConstraint& support = rows.rows[i];
      const ConstraintPoint &above = rows.points[p], &below = rows.points[support.firstPoint];
      double ofSupport = 0.0, ofRow = 0.0;
      for (int k = 0; k < 3; ++k) {
        const double axes = row.axes[0][k] * support.axes[0][k];
        ofSupport += below.share * above.response[k] * axes;
        ofRow += above.share * below.response[k] * axes;
      }
      const double ratio = -ofSupport * support.mass;
      found.mobility += ratio * ofRow;
      found.rows[found.count] = i, found.ratios[found.count++] = ratio;
    }
    return found;
  }

  /// Adds to the supports' impulses what keeps their speeds when a row's impulse changes along the normal.
  void passOn(const Supports& supports, double change) const {
    for (std::size_t k = 0; k < supports.count; ++k) {
      ContactConstraint& support = rows.rows[supports.rows[k]];
      const double added = supports.ratios[k] * change;
      applyImpulse(rows, support, {added, 0.0, 0.0});
      impulse(support).n += added;
    }
  }

  bool canPassOn(const Supports& supports, double change) const {
    for (std::size_t k = 0; k < supports.count; ++k)
      if (impulse(rows.rows[supports.rows[k]]).n + supports.ratios[k] * change < 0.0) return false;
    return supports.count > 0 && supports.mobility > kLeastMobility * supports.unsupported;
  }

  /// Solves a contact together with the supports of its points. Returns the mobility along the normal (1/kg).
  double solveSupported(ContactConstraint& row, bool free) const {
    const Supports supports = supportsOf(row);
    ContactVector& total = impulse(row);
    const double mass = 1.0 / supports.mobility, softness = row.softness * row.mobility * mass;
    const double n = normalImpulse(row, mass, softness, total.n, row.target, speedAlong(rows, row));
    const double change = n - total.n;
    if (!canPassOn(supports, change)) {
      solveContact(rows, row, total, row.target, free);
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
    row.active = true;
    row.maxFriction = 0.0;
    row.minFrictionChange = kMinFrictionChange;
    row.direction = ContactVector();
    row.change = ContactVector();
    rows.rowNodes[i].isLeftOut = false;
    markChanged(i);
    rows.active[set.begin + set.activeCount++] = i;
  }

  /// Applies the impulse of the last substep as a warm start.
  void start(RowSet& set, std::uint32_t i) const {
    ContactConstraint& row = rows.rows[i];
    ContactVector& sum = impulse(row);
    const bool takesPart = row.mass > 0.0 && (stage == Stage::Positions || row.positionImpulse.n > 0.0);
    row.active = false;
    if (!takesPart || sum.n <= 0.0) sum = ContactVector();
    row.before = sum;
    if (sum.n > 0.0 || (takesPart && stage == Stage::Velocities)) activate(set, i);
    if (sum.n > 0.0) applyImpulse(rows, row, sum);
  }

  void start() {
    for (JointConstraint& j : rows.joints) {
      apply(j, impulse(j));
      j.direction = 0.0;
    }
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
        const ContactConstraint& row = rows.rows[i];
        if (!row.active && row.mass > 0.0 && speedAlong(rows, row) < row.target) activate(set, i);
      }
      const auto first = rows.active.begin() + set.begin;
      if (set.activeCount > countBefore) std::sort(first, first + set.activeCount);
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

  SweepChange sweepJoints(bool free) const {
    SweepChange change;
    for (JointConstraint& j : rows.joints) {
      if (j.mass == 0.0) continue;
      if (free && j.contact != JointConstraint::kHeld) limitRolling(j);
      solveJoint(bodies, j, impulse(j));
      change.add(j.change * j.change, 1.0 / j.mass);
    }
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
        solveContact(rows, row, impulse(row), row.target, free);
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
        if (isOfPoint(contactOf(rows, i))) solveContact(rows, row, impulse(row), row.target, false);
      });
    });
  }

  int run() {
    std::fill(rows.changedIn.begin(), rows.changedIn.end(), 0);
    std::fill(rows.nodes.begin(), rows.nodes.end(), ConstraintNode());
    start();
    tolerance = rows.empty() ? kTightTolerance : rows.tolerance;
    double before = 0.0;
    int lastFree = kFreeSweeps;
    bool all = true;
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
      if (ends) lastFree = count + kFreeSweeps, restoreMinFriction();
      // restart the directions where the last sweep has changed more than the one before
      const double beta = before > 0.0 ? change.energy / before : 0.0;
      stepAlongDirections(beta <= 1.0 ? beta : 0.0);
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

}  // namespace

int solvePositions(IslandConstraints& rows, LinkedBodies& bodies, Team& team, double dt, double tick) {
  if (!startSolve(rows, bodies)) return 0;
  aimAnchors(bodies, dt, tick);
  const bool anchored = !bodies.anchors.empty();
  forEachRow(rows, team,
             [&](std::size_t i) { setTarget(rows, contactOf(rows, i), rows.rows[i], anchored, dt, tick); });
  return Solve{rows, bodies, team, Stage::Positions, dt}.run();
}

int solveVelocities(IslandConstraints& rows, LinkedBodies& bodies, Team& team) {
  if (!startSolve(rows, bodies)) return 0;
  forEachRow(rows, team, [&](std::size_t i) {
    ContactConstraint& row = rows.rows[i];
    row.target = row.bounces ? row.speedAfter(speedAlong(rows, row)) : 0.0;
  });
  const int sweeps = Solve{rows, bodies, team, Stage::Velocities}.run();
  forEachRow(rows, team, [&](std::size_t i) {
    if (contactOf(rows, i).restitution > 0.0) keepVelocity(rows, rows.rows[i]);
  });
  return sweeps;
}

}  // namespace limber
