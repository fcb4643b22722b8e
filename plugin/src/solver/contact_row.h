// SPDX-License-Identifier: Zlib
#pragma once

// One row of an island's contacts: its speeds and impulses, and the laws by which it is solved.

#include "solver/contacts.h"

namespace limber {

// --- speeds and impulses -----------------------------------------------------------------------------------

/// Components (normal, tangents) of a vector.
inline Eigen::Vector3d inAxes(const ContactConstraint& row, const Eigen::Vector3d& v) {
  using ConstMap = Eigen::Map<const Eigen::Vector3d>;
  return {ConstMap(row.axes[0]).dot(v), ConstMap(row.axes[1]).dot(v), ConstMap(row.axes[2]).dot(v)};
}

/// Sets the row's masses.
void setMobility(ContactConstraint& row, const Mobility& mobility);

/// Sets the share of point i, which has an inverse mass.
inline void setShare(IslandConstraints& rows, std::uint32_t i, double share) {
  rows.points[i].share = share;
  for (int k = 0; k < 3; ++k) rows.points[i].response[k] = share * rows.momentArms[i].inverseMass[k];
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

/// m/s, of side a relative to b. With a couple the normal speeds of the points add tangential speeds, at
/// their moment arms.
inline ContactVector speedsOf(const IslandConstraints& rows, const ContactConstraint& row) {
  Motion m;
  ContactVector ofCouple;
  const bool hasCouple = row.couple == Couple::Soft;
  for (std::uint32_t i = row.firstPoint; i < row.endPoint; ++i) {
    const ConstraintPoint& p = rows.points[i];
    const Motion v = {p.velocity[0], p.velocity[1], p.velocity[2]};
    m.x += p.share * v.x;
    m.y += p.share * v.y;
    m.z += p.share * v.z;
    if (!hasCouple) continue;
    const double speed = along(row.axes[0], v);
    ofCouple.u += rows.momentArms[i].across[0] * speed;
    ofCouple.v += rows.momentArms[i].across[1] * speed;
  }
  ContactVector speeds{row.surfaceSpeeds.n + along(row.axes[0], m),
                       row.surfaceSpeeds.u + along(row.axes[1], m),
                       row.surfaceSpeeds.v + along(row.axes[2], m)};
  for (std::uint32_t i = row.firstRotation; i < row.endRotation; ++i) {
    const ConstraintRotation& t = rows.rotations[i];
    const Motion w = angularVelocityOf(t);
    speeds += {along(t.speeds[0], w), along(t.speeds[1], w), along(t.speeds[2], w)};
  }
  if (hasCouple) speeds += ofCouple;
  return speeds;
}

/// speedsOf().n
inline double speedAlong(const IslandConstraints& rows, const ContactConstraint& row) {
  double speed = row.surfaceSpeeds.n + along(row.axes[0], motionOf(rows, row));
  for (std::uint32_t i = row.firstRotation; i < row.endRotation; ++i)
    speed += along(rows.rotations[i].speeds[0], angularVelocityOf(rows.rotations[i]));
  return speed;
}

/// Sets `lastVelocity`, in world axes: the normal may change.
inline void keepVelocity(const IslandConstraints& rows, ContactConstraint& row) {
  const ContactVector speeds = speedsOf(rows, row);
  for (int k = 0; k < 3; ++k)
    row.lastVelocity[k] = row.axes[0][k] * speeds.n + row.axes[1][k] * speeds.u + row.axes[2][k] * speeds.v;
}

/// Applies an impulse to both sides.
inline void applyImpulse(IslandConstraints& rows, ContactConstraint& row, const ContactVector& j) {
  const double(&a)[3][3] = row.axes;
  const double x = a[0][0] * j.n + a[1][0] * j.u + a[2][0] * j.v;
  const double y = a[0][1] * j.n + a[1][1] * j.u + a[2][1] * j.v;
  const double z = a[0][2] * j.n + a[1][2] * j.u + a[2][2] * j.v;
  const bool hasCouple = row.couple == Couple::Soft;
  for (std::uint32_t i = row.firstPoint; i < row.endPoint; ++i) {
    const ConstraintPoint& p = rows.points[i];
    double v[3] = {p.velocity[0] + p.response[0] * x, p.velocity[1] + p.response[1] * y,
                   p.velocity[2] + p.response[2] * z};
    if (hasCouple) {
      const MomentArm& momentArm = rows.momentArms[i];
      const double impulse = momentArm.across[0] * j.u + momentArm.across[1] * j.v;
      for (int k = 0; k < 3; ++k) v[k] += momentArm.response[k] * impulse;
    }
    for (int k = 0; k < 3; ++k) p.velocity[k] = v[k];
  }
  for (std::uint32_t i = row.firstRotation; i < row.endRotation; ++i) {
    const ConstraintRotation& t = rows.rotations[i];
    double* w = t.body->angularVelocity.data();
    for (int k = 0; k < 3; ++k)
      w[k] += t.response[0][k] * j.n + t.response[1][k] * j.u + t.response[2][k] * j.v;
  }
  row.impulse += j;
}

/// The same for an impulse along the normal of a contact of a point, see isOfPoint().
inline void applyNormalImpulse(IslandConstraints& rows, ContactConstraint& row, double j) {
  const ConstraintPoint& p = rows.points[row.firstPoint];
  for (int k = 0; k < 3; ++k) p.velocity[k] += p.response[k] * (row.axes[0][k] * j);
  row.impulse.n += j;
}

// --- before a solve ----------------------------------------------------------------------------------------

/// Softness of contacts (a proximal term): a contact yields to the change of its impulse since the last
/// substep by this share of the yield without other contacts, and along the normal also to 1 - kKept of the
/// impulse itself. Contact impulses of rigid bodies against each other are not unique; with this term they
/// converge instead of drifting, and piles come to rest. In a pile of ten boxes it costs 3e-5 m of height. A
/// single point on a static or kinematic object needs no softness: its springs determine its impulse. Between
/// two of them it needs softness, and so do joints of bodies that such objects press: no motion satisfies
/// all, and the impulses would grow without limit.
constexpr double kSoftness = 0.02;
constexpr double kKept = 0.8;

/// A contact that removes an overlap may push against a body that cannot move away: one that anchors hold, or
/// the folds of a soft body around an object. There each overlap that is removed makes another one, and the
/// energy would grow without limit. So the work of a contact in a tick is at most this multiple of m v^2,
/// with the row's mass and either the speed at which overlaps are removed or, if that is larger, the mean
/// square of the velocities in the island: a fast hit makes overlaps, since its contacts are found late, and
/// energy that is missing until they are removed. A contact with an impulse above m v may do less work, in
/// proportion: contacts that push against each other have impulses of any size. The smaller multiple is for
/// islands with anchors and for contacts between soft bodies, which both yield.
constexpr double kRecoveryWork = 2.4, kSmallRecoveryWork = 0.3;

/// Share of the recovery speed up to which the work is not limited. Under a heavy body points of a gram could
/// else not remove the small overlaps that every solve leaves, and a ball on a cloth would not come to rest.
constexpr double kFreeRecovery = 0.01;

/// Returns the factor of the largest work of a contact; 0: there is no limit where nothing soft or anchored
/// yields, nor for contacts that separate two bodies along one direction, nor for single points, unless
/// joints hold all points of their body (`framed`).
inline double recoveryWorkFactor(const Contact& c, bool anchored, bool framed) {
  constexpr auto kSoft = ContactPoint::Kind::Soft;
  if (c.separates) return 0.0;
  if (isOfPoint(c)) return framed ? kSmallRecoveryWork : 0.0;
  if (!anchored && c.a.kind != kSoft && c.b.kind != kSoft) return 0.0;
  return anchored || (c.a.kind == kSoft && c.b.kind == kSoft) ? kSmallRecoveryWork : kRecoveryWork;
}

/// Returns the largest work (J) of a contact in a substep of `share` of the tick that removes an overlap.
inline double maxRecoveryWork(const IslandConstraints& rows, const ContactConstraint& row, double share) {
  if (!(row.target > 0.0) || row.workFactor == 0.0) return HUGE_VAL;
  const double squaredSpeed = std::max(row.recoverySpeed * row.recoverySpeed, rows.squaredMotion);
  const double work = row.workFactor * share * row.mass * squaredSpeed;
  const double load = share * row.mass * std::sqrt(squaredSpeed), impulse = row.positionImpulse.n;
  return impulse > load ? work * load / impulse : work;
}

/// Returns the speed (m/s) by which the row yields to its impulse of the last substep, for ever: a light body
/// between a heavy one and the floor sinks with it, until an overlap is removed as fast. A rigid body does so
/// no faster than its overlaps are removed: those that nothing can remove must not press ever harder.
inline double yieldOf(const ContactConstraint& row) {
  const double yield = row.softness * (1.0 - kKept) * row.positionImpulse.n * row.mobility;
  return row.rigidA ? std::min(yield, row.recoverySpeed) : yield;
}

/// Least cosine of the angle between opposite impulses, negated.
constexpr double kOpposite = 0.5;

/// Whether the row's point is between two static or kinematic objects.
inline bool isPinched(const IslandConstraints& rows, const ContactConstraint& row) {
  if (row.beside == ContactConstraint::kNoRow) return false;
  const ContactConstraint& other = rows.rows[row.beside];
  const double* n = other.axes[0];
  return other.mass > 0.0 && along(row.axes[0], {n[0], n[1], n[2]}) < -kOpposite;
}

/// Sets the target speed of the contact before a drift of dt seconds. A bounce has no softness.
inline void setTarget(IslandConstraints& rows, std::size_t i, double dt, double tick) {
  ContactConstraint& row = rows.rows[i];
  row.softness = row.ofPoint && !isPinched(rows, row) ? 0.0 : kSoftness;
  const double closing = std::exchange(row.closing, 0.0) / dt;
  row.target = minSpeed(row.gap, row.recoverySpeed + yieldOf(row) + closing, dt);
  row.freeSpeed = kFreeRecovery * row.recoverySpeed + closing;
  row.maxWork = maxRecoveryWork(rows, row, dt / tick);
  row.bounces = false;
  if (!row.restitutes) return;
  const Contact& c = contactOf(rows, i);
  const double approach = -speedAlong(rows, row);
  const double before = -along(row.axes[0], {row.lastVelocity[0], row.lastVelocity[1], row.lastVelocity[2]});
  addBounce(row, c, row.gap, approach, before, dt);
  if (row.bounces) row.softness = 0.0, row.maxWork = HUGE_VAL;
}

// --- in a sweep --------------------------------------------------------------------------------------------

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

/// Returns the impulse, 0 or more, that changes the speed along the normal from `speed` to the target (m/s),
/// with the row's softness. `sum` (N s) is the present impulse. If its work would be more than maxWork, the
/// result n is smaller: with the impulse n0 for speed 0,
///     n (n - n0) / m = maxWork,
/// or, if that is larger, the impulse for freeSpeed. `mass` (kg) and `softness` are the row's,
/// unless it is supported.
inline double normalImpulse(const ContactConstraint& row, double mass, double softness, double sum,
                            double speed) {
  const double yielding = softness * (sum - kKept * row.before.n);
  const auto impulseFor = [&](double wanted) {
    return std::max(0.0, sum + ((wanted - speed) * mass - yielding) / (1.0 + softness));
  };
  const double n = impulseFor(row.target), atRest = sum - speed * mass;
  if (!(n * (n - atRest) > mass * row.maxWork)) return n;
  const double limited = 0.5 * (atRest + std::sqrt(atRest * atRest + 4.0 * mass * row.maxWork));
  return std::max(limited, impulseFor(std::min(row.target, row.freeSpeed)));
}

/// Sets row.change. `forced`: the minimum of addFriction() has made the step longer.
inline void noteReversal(ContactConstraint& row, const ContactVector& change, bool forced) {
  if (forced && change.u * row.change.u + change.v * row.change.v < 0.0)
    row.minFrictionChange *= kAfterReversal;
  row.change = change;
}

/// Brings the speed along the normal to the row's target with the impulse `total`, which is 0 or more along
/// the normal, with friction within its cone. `free`: the cone follows the normal impulse. Sets row.change.
inline void solveContact(IslandConstraints& rows, ContactConstraint& row, ContactVector& total, bool free) {
  const ContactVector speeds = speedsOf(rows, row), earlier = total;
  ContactVector sum = earlier;
  sum.n = normalImpulse(row, row.mass, row.softness, sum.n, speeds.n);
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

}  // namespace limber
