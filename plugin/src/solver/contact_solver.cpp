// SPDX-License-Identifier: Zlib
// Solves contacts, joints and anchors of a group together, by sweeps over their rows.
#include "solver/contacts.h"

#include "solver/contact_constraint.h"
#include "solver/plane_contacts.h"

#include <Eigen/LU>

#include <algorithm>
#include <cmath>

namespace limber {
namespace {

// --- impulses along one line -------------------------------------------------------------------------------

using Eigen::Matrix2d;
using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;
using ConstMap = Eigen::Map<const Vector3d>;

/// A triangle's share may leave it by so much before its place stays put until the next tick.
constexpr double kMaxShare = 1.25;

/// Of the arm of a rigid body's place: what stops it from farther away acts as if it had come nearer.
constexpr double kMaxReach = 0.3;

/// Points across a normal that are this much thinner one way than the other, squared, are in a line.
constexpr double kThin = 1e-6;

constexpr std::size_t kMaxRowPoints = 6;

/// The points of a row as its axes show them.
struct Places {
  std::size_t count = 0;
  std::array<Vector3d, kMaxRowPoints>
      displacement;                   ///< m, from the middle of the side: along the normal, then across
  Vector3d apart = Vector3d::Zero();  ///< m, from place b to a, likewise
  Matrix2d inverse;                   ///< 1/m^2, of M

  Vector2d momentArm(std::size_t i) const { return displacement[i].tail<2>(); }
};

Vector3d vectorInAxes(const ContactConstraint& row, const Vector3d& x) {
  return {ConstMap(row.axes[0]).dot(x), ConstMap(row.axes[1]).dot(x), ConstMap(row.axes[2]).dot(x)};
}

/// The soft points from `first` to `end`.
void addSide(const IslandConstraints& rows, const ContactConstraint& row, std::uint32_t first,
             std::uint32_t end, const Vector3d& origin, Places& places) {
  const std::size_t start = places.count;
  Vector3d middle = Vector3d::Zero();
  for (std::uint32_t i = first; i < end; ++i) {
    const Vector3d x = vectorInAxes(row, ConstMap(rows.momentArms[i].position) - origin);
    places.apart += rows.points[i].share * x;
    places.displacement[places.count++] = x;
    middle += x / double(end - first);
  }
  for (std::size_t i = start; i < places.count; ++i) places.displacement[i] -= middle;
}

/// The inverse of m with eigenvalues below `least` at 1 / (least^2 / value): any function f of a symmetric
/// matrix of two rows is the straight line through f at its eigenvalues, middle -+ half.
Matrix2d cautiousInverse(const Matrix2d& m, double least) {
  const auto inverted = [&](double value) {
    return value > 0.0 ? std::min(1.0 / value, value / (least * least)) : 0.0;
  };
  const double middle = 0.5 * m.trace(), half = std::hypot(0.5 * (m(0, 0) - m(1, 1)), m(0, 1));
  const double low = inverted(middle - half), high = inverted(middle + half);
  const double slope = half > 0.0 ? 0.5 * (high - low) / half : 0.0;
  return 0.5 * (low + high) * Matrix2d::Identity() + slope * (m - middle * Matrix2d::Identity());
}

/// The inverse of M; where levers are shorter than `apart` (m), less: they would have to bear more than the
/// contact.
void invert(Places& places, double apart) {
  Matrix2d m = Matrix2d::Zero();
  for (std::size_t i = 0; i < places.count; ++i) m += places.momentArm(i) * places.momentArm(i).transpose();
  const double least = std::max(apart * apart, kThin * m.trace());
  const double middle = 0.5 * m.trace(), determinant = m.determinant();
  const double smallest = middle - std::sqrt(std::max(0.0, middle * middle - determinant));
  places.inverse = smallest > least ? Matrix2d(m.inverse()) : cautiousInverse(m, least);
}

void setShare(IslandConstraints& rows, std::uint32_t i, double share) {
  ConstraintPoint& point = rows.points[i];
  point.share = share;
  for (int k = 0; k < 3; ++k) point.response[k] = share * rows.momentArms[i].inverseMass[k];
}

/// Makes the places meet across the normal, as far as the soft ones can be moved. `first`: the row's point
/// that places begins with.
void moveShares(IslandConstraints& rows, std::uint32_t first, Places& places) {
  const Vector2d more = places.inverse * places.apart.tail<2>();
  std::array<double, kMaxRowPoints> shares;
  for (std::size_t i = 0; i < places.count; ++i) {
    shares[i] = rows.points[first + i].share - places.momentArm(i).dot(more);
    if (!(std::abs(shares[i]) <= kMaxShare)) return;
  }
  for (std::size_t i = 0; i < places.count; ++i) {
    places.apart -= places.momentArm(i).dot(more) * places.displacement[i];
    setShare(rows, first + static_cast<std::uint32_t>(i), shares[i]);
  }
}

void setMomentArm(const ContactConstraint& row, const Vector2d& across, MomentArm& momentArm) {
  for (int k = 0; k < 2; ++k) momentArm.across[k] = across[k];
  for (int k = 0; k < 3; ++k) momentArm.response[k] = momentArm.inverseMass[k] * row.axes[0][k];
}

void joinSoft(IslandConstraints& rows, const ContactConstraint& row) {
  const Vector3d origin = ConstMap(rows.momentArms[row.firstPoint].position);
  Places places;
  addSide(rows, row, row.firstPoint, row.firstOfB, origin, places);
  addSide(rows, row, row.firstOfB, row.endPoint, origin, places);
  invert(places, places.apart[0]);
  moveShares(rows, row.firstPoint, places);
  for (std::size_t i = 0; i < places.count; ++i)
    setMomentArm(row, places.apart[0] * (places.inverse * places.momentArm(i)),
                 rows.momentArms[row.firstPoint + i]);
}

void joinRigid(IslandConstraints& rows, const ContactConstraint& row, const Contact& c) {
  const bool softIsA = c.a.kind == ContactPoint::Kind::Soft;
  ConstraintRotation& turn = rows.rotations[row.firstRotation];
  Vector3d arm = softIsA ? c.b.arm : c.a.arm;
  const Vector3d origin = turn.body->position + arm;
  Places places;
  if (softIsA)
    addSide(rows, row, row.firstPoint, row.firstOfB, origin, places);
  else
    addSide(rows, row, row.firstOfB, row.endPoint, origin, places);
  invert(places, 0.0);
  moveShares(rows, softIsA ? row.firstPoint : row.firstOfB, places);
  const double sign = softIsA ? -1.0 : 1.0;
  const double most = kMaxReach * arm.norm(), distance = places.apart.norm();
  if (distance > most) places.apart *= most / distance;
  for (int k = 0; k < 3; ++k) arm -= sign * places.apart[k] * ConstMap(row.axes[k]);
  for (int k = 0; k < 3; ++k) {
    const Vector3d speeds = sign * arm.cross(ConstMap(row.axes[k]));
    Eigen::Map<Vector3d>(turn.speeds[k]) = speeds;
    Eigen::Map<Vector3d>(turn.response[k]) = turn.body->inverseInertia * speeds;
  }
}

/// 1/kg: speeds along, across and across both, of one impulse in each of these directions.
Matrix3d momentArmMobility(const IslandConstraints& rows, const ContactConstraint& row) {
  const Eigen::Map<const Matrix3d> axes(row.axes[0]);  // its columns
  Matrix3d mobility = Matrix3d::Zero();
  for (std::uint32_t i = row.firstPoint; i < row.endPoint; ++i) {
    const ConstraintPoint& point = rows.points[i];
    const MomentArm& momentArm = rows.momentArms[i];
    const Vector3d across(0.0, momentArm.across[0], momentArm.across[1]);
    const Matrix3d changes =
        ConstMap(point.response).asDiagonal() * axes + ConstMap(momentArm.response) * across.transpose();
    mobility += (point.share * axes + axes.col(0) * across.transpose()).transpose() * changes;
  }
  for (std::uint32_t i = row.firstRotation; i < row.endRotation; ++i)
    mobility += Eigen::Map<const Matrix3d>(rows.rotations[i].speeds[0]).transpose() *
                Eigen::Map<const Matrix3d>(rows.rotations[i].response[0]);
  return mobility;
}

/// Makes the impulses of a contact between bodies that move act along one line, as the bodies lie now, so
/// that they change no angular momentum. For contacts that are about to bear something: where others will
/// touch is not yet seen.
///
/// Let D = sum s_i x_i be the way from place b to place a, s_i the points' shares (below 0 on b). Impulses J
/// at the two places are a couple D x J. With y_i the points' ways across the normal n from the middle of
/// their side, M = sum y_i y_i^T, and D = d n + T,
///     s_i -= y_i . M^-1 T          moves the places until T is 0, and
///     J_i = s_i J + n (l_i . J),   l_i = d M^-1 y_i,
/// lets the levers of edges and triangles bear what is left, d n x J; neither changes the sum of a side. That
/// is the least change that does. The places' relative speed across grows by sum l_i (n . v_i): the surfaces
/// touch in the middle, and turn. A rigid body's place moves by what no soft one's can.
void joinPlaces(IslandConstraints& rows, std::size_t contact) {
  ContactConstraint& row = rows.rows[contact];
  if (row.couple == Couple::Nobody) return;
  if (row.couple == Couple::Soft)
    joinSoft(rows, row);
  else
    joinRigid(rows, row, rows.contacts[contact]);
  // a sweep that takes a row for heavier than it is diverges
  setMobility(row, momentArmMobility(rows, row));
}

// --- sweeps ------------------------------------------------------------------------------------------------

/// Few solves need more than a tenth of it. Ending those early costs more: the remaining error slows down the
/// solves of all following substeps.
constexpr int kMaxSweeps = 50;

/// Which of a row's two impulses a solve is about.
enum class Stage { Positions, Velocities };

/// Contacts give way by this share of what one alone would give way to the change of its impulse since the
/// last substep (a proximal term), and normals to a fifth of the impulse itself. What contacts of rigid
/// bodies bear against each other, of which nothing else tells how it is shared out, then settles instead of
/// wandering, and piles come to rest. On a pile of ten boxes this costs 3e-5 m of height. A single point on
/// a static or kinematic object needs none of this: its springs tell what it bears.
constexpr double kSoftness = 0.02;
constexpr double kKept = 0.8;

/// Of the friction of a contact that slides: by so much at least a sweep turns it against the sliding.
/// Contacts of one body may bear friction against each other that does nothing but use up their cones;
/// without this a slow slide would take long to get it out.
constexpr double kMinTurn = 0.1;

/// m/s, as IslandConstraints::tolerance where there are anchors only: they keep the bodies together to
/// rounding.
constexpr double kTightTolerance = 1e-10;

/// Sweeps in which cones of friction follow the normals and friction is turned by kMinTurn. With both,
/// sweeps may go round in circles for ever; without, they descend to the least of a convex energy. But cones
/// that stop too early are those of an unfinished solve, which depends on the order of the contacts.
constexpr int kFreeSweeps = 15;

/// Friction that stops the sliding (u, v) (m/s) altogether, or as much as there is, against the sliding:
/// nearer to the least energy of the row alone, or a step of projected gradient towards it.
inline void addFriction(const ContactConstraint& row, double u, double v, double leastTurn,
                        ContactVector& sum) {
  const double* m = row.acrossMass;
  const double most = row.maxFriction;
  u += row.acrossSoftness * (sum.u - row.before.u);
  v += row.acrossSoftness * (sum.v - row.before.v);
  const double stopU = sum.u - (m[0] * u + m[1] * v);
  const double stopV = sum.v - (m[1] * u + m[2] * v);
  if (stopU * stopU + stopV * stopV <= most * most) {
    sum.u = stopU, sum.v = stopV;
    return;
  }
  const double speed = std::sqrt(u * u + v * v);
  const double turn = speed > 0.0 ? std::max(row.turnMass, leastTurn * most / speed) : 0.0;
  sum.u -= turn * u, sum.v -= turn * v;
  const double squared = sum.u * sum.u + sum.v * sum.v;
  if (squared <= most * most) return;
  const double scale = most / std::sqrt(squared);
  sum.u *= scale, sum.v *= scale;
}

/// Brings the speed along the normal up to `target` (m/s), with the impulse `total` 0 or more along it and
/// friction within its cone, which is `free` to follow; row.change is what this has changed.
inline void solveContact(IslandConstraints& rows, ContactConstraint& row, ContactVector& total, double target,
                         bool free) {
  const ContactVector speeds = speedsOf(rows, row), earlier = total;
  ContactVector sum = earlier;
  const double strain = row.softness * (sum.n - kKept * row.before.n);
  sum.n = std::max(0.0, sum.n + ((target - speeds.n) * row.mass - strain) / (1.0 + row.softness));
  const double more = sum.n - earlier.n;
  if (free) row.maxFriction = row.friction * sum.n;
  addFriction(row, speeds.u + more * row.acrossAlong[0], speeds.v + more * row.acrossAlong[1],
              free ? kMinTurn : 0.0, sum);
  const ContactVector change{more, sum.u - earlier.u, sum.v - earlier.v};
  applyImpulse(rows, row, change);
  row.change = change;
  total = sum;
}

/// Returns the maximum speed (m/s) at which an overlap is removed. Where anchors hold bodies together, a
/// contact may push against a body that cannot move away. Its work in a tick is limited to the kinetic energy
/// that the moved mass has at this speed.
double partingSpeed(const Contact& c, const ContactConstraint& row, const LinkedBodies& bodies, double dt,
                    double tick) {
  if (bodies.anchors.empty()) return c.recoverySpeed;
  const double borne =
      std::max(row.positionImpulse.n / dt * tick, c.impulse.along + row.impulse.n);  // N s in the tick
  const double free = row.mass * c.recoverySpeed;
  return borne > free ? c.recoverySpeed * free / borne : c.recoverySpeed;
}

/// Whether side a is a single point mass and side b a static or kinematic object.
bool isOfPoint(const Contact& c) {
  return c.a.kind == ContactPoint::Kind::Soft && c.a.count == 1 && c.b.kind == ContactPoint::Kind::World;
}

/// What the contact needs before a drift of dt seconds. What would meet in it parts by Newton's law of
/// restitution, and does not give way.
void aim(const IslandConstraints& rows, const Contact& c, ContactConstraint& row, double dt, double parting) {
  row.softness = isOfPoint(c) ? 0.0 : kSoftness;
  row.target = row.gap >= 0.0 ? -row.gap / dt : std::min(-kRecovery * row.gap / dt, parting);
  row.bounces = false;
  if (!(c.restitution > 0.0)) return;
  const double approach = -speedAlong(rows, row);
  if (!(row.gap < approach * dt)) return;
  // where the surface is followed its normal is another one now
  const double before = c.held || c.corners.count > 0 || c.spheres > 0.0 ? approach : -row.settled;
  const Bounce bounce = bounceOf(row.gap, approach, before, c.restitution, c.bounceThreshold, dt);
  if (bounce.rests) return;
  row.softness = 0.0;
  row.bounces = true;
  row.target = row.gap < 0.0 ? std::max(bounce.mean, row.target) : bounce.mean;
  row.rebound = bounce.rebound;
}

/// What a sweep has changed: the largest change of a velocity, squared, and the sum of all as an energy.
struct Change {
  double largest = 0.0, energy = 0.0;
  void add(double squaredImpulse, double mobility) {
    const double work = squaredImpulse * mobility;
    largest = std::max(largest, work * mobility);
    energy += work;
  }
  void add(const Eigen::Vector3d& velocity, const Eigen::Vector3d& impulse) {
    largest = std::max(largest, velocity.squaredNorm());
    energy -= velocity.dot(impulse);
  }
  bool within(double tolerance) const { return largest <= tolerance * tolerance; }
};

/// One stage of all rows of a group. Contacts that bear nothing and are not crossed either are left out of
/// the sweeps, and looked at again when these have ended.
struct Solve {
  IslandConstraints& rows;
  LinkedBodies& bodies;
  Stage stage;
  double dt = 0.0;  ///< s, of the drift that anchors are to end together after; 0 when settling

  ContactVector& impulse(ContactConstraint& row) const {
    return stage == Stage::Positions ? row.positionImpulse : row.velocityImpulse;
  }
  double& impulse(JointConstraint& j) const {
    return stage == Stage::Positions ? j.positionImpulse : j.velocityImpulse;
  }
  Eigen::Vector3d& impulse(LinkAnchor& a) const {
    return stage == Stage::Positions ? a.positionImpulse : a.velocityImpulse;
  }

  void activate(std::uint32_t i) {
    joinPlaces(rows, i);
    ContactConstraint& row = rows.rows[i];
    row.active = true;
    row.maxFriction = 0.0;
    row.direction = ContactVector();
    row.change = ContactVector();
    rows.active.push_back(i);
  }

  /// What the last substep bore is about what this one will.
  void start() {
    for (JointConstraint& j : rows.joints) {
      applyImpulse(bodies, j, impulse(j));
      j.direction = 0.0;
    }
    for (LinkAnchor& anchor : bodies.anchors) {
      limber::applyImpulse(bodies, anchor, impulse(anchor));
      anchor.direction.setZero();
    }
    rows.active.clear();
    for (std::uint32_t i = 0; i < rows.rows.size(); ++i) {
      ContactConstraint& row = rows.rows[i];
      ContactVector& sum = impulse(row);
      const bool takesPart = row.mass > 0.0 && (stage == Stage::Positions || row.positionImpulse.n > 0.0);
      row.active = false;
      if (!takesPart || sum.n <= 0.0) sum = ContactVector();
      row.before = sum;
      if (sum.n > 0.0 || (takesPart && stage == Stage::Velocities)) activate(i);
      if (sum.n > 0.0) applyImpulse(rows, row, sum);
    }
    if (stage == Stage::Positions) activateCrossed();
  }

  /// Takes in the contacts that would be crossed in the coming drift. Returns whether there are any.
  bool activateCrossed() {
    const std::size_t count = rows.active.size();
    for (std::uint32_t i = 0; i < rows.rows.size(); ++i) {
      const ContactConstraint& row = rows.rows[i];
      if (!row.active && row.mass > 0.0 && speedAlong(rows, row) < row.target) activate(i);
    }
    if (rows.active.size() == count) return false;
    std::sort(rows.active.begin(), rows.active.end());
    return true;
  }

  /// As cones of friction, see kFreeSweeps.
  void limitRolling(JointConstraint& j) const {
    j.upper = j.rolling * impulse(rows.rows[j.contact]).n;
    j.lower = -j.upper;
  }

  Change sweep(bool free) {
    Change change;
    for (JointConstraint& j : rows.joints) {
      if (j.mass == 0.0) continue;
      if (free && j.contact != JointConstraint::kHeld) limitRolling(j);
      solveJoint(bodies, j, impulse(j));
      change.add(j.change * j.change, 1.0 / j.mass);
    }
    for (LinkAnchor& anchor : bodies.anchors) {
      const Eigen::Vector3d error = speedError(bodies, anchor, dt);
      anchor.change = -(anchor.mass * error);
      limber::applyImpulse(bodies, anchor, anchor.change);
      impulse(anchor) += anchor.change;
      change.add(error, anchor.change);
    }
    for (const std::uint32_t i : rows.active) {
      ContactConstraint& row = rows.rows[i];
      solveContact(rows, row, impulse(row), row.target, free);
      change.add(row.change.squaredNorm(), row.mobility);
    }
    return change;
  }

  /// On along `beta` times the last direction; the new one is that and what the sweep has changed.
  void stepOn(double beta) {
    for (JointConstraint& j : rows.joints) {
      j.direction *= beta;
      applyImpulse(bodies, j, j.direction);
      impulse(j) += j.direction;
      j.direction += j.change;
    }
    for (LinkAnchor& anchor : bodies.anchors) {
      anchor.direction *= beta;
      limber::applyImpulse(bodies, anchor, anchor.direction);
      impulse(anchor) += anchor.direction;
      anchor.direction += anchor.change;
    }
    for (const std::uint32_t i : rows.active) {
      ContactConstraint& row = rows.rows[i];
      row.direction *= beta;
      applyImpulse(rows, row, row.direction);
      impulse(row) += row.direction;
      row.direction += row.change;
    }
  }

  bool hasNothingToDo() const { return rows.active.empty() && rows.joints.empty() && bodies.anchors.empty(); }

  int run() {
    start();
    const double tolerance = rows.empty() ? kTightTolerance : rows.tolerance;
    double before = 0.0;
    int lastFree = kFreeSweeps;
    for (int count = 1; !hasNothingToDo(); ++count) {
      const Change change = sweep(count <= lastFree);
      if (count == kMaxSweeps) return count;
      const bool ends = change.within(tolerance);
      if (ends && (stage == Stage::Velocities || !activateCrossed())) return count;
      if (ends) lastFree = count + kFreeSweeps;
      // where the last sweep has changed more than the one before, its direction leads astray
      const double beta = before > 0.0 ? change.energy / before : 0.0;
      stepOn(beta <= 1.0 ? beta : 0.0);
      before = change.energy;
    }
    return 0;
  }
};

}  // namespace

int solvePositions(IslandConstraints& rows, LinkedBodies& bodies, double dt, double tick) {
  if (rows.empty() && bodies.anchors.empty()) return 0;
  rotateResponses(rows);
  updateAnchorMasses(bodies);
  aimAnchors(bodies, dt, tick);
  for (std::size_t i = 0; i < rows.rows.size(); ++i) {
    const Contact& c = rows.contacts[i];
    aim(rows, c, rows.rows[i], dt, partingSpeed(c, rows.rows[i], bodies, dt, tick));
  }
  return Solve{rows, bodies, Stage::Positions, dt}.run();
}

int solveVelocities(IslandConstraints& rows, LinkedBodies& bodies) {
  if (rows.empty() && bodies.anchors.empty()) return 0;
  rotateResponses(rows);
  updateAnchorMasses(bodies);
  for (ContactConstraint& row : rows.rows)
    row.target = row.bounces ? speedAlong(rows, row) + row.rebound : 0.0;
  const int sweeps = Solve{rows, bodies, Stage::Velocities}.run();
  for (std::size_t i = 0; i < rows.rows.size(); ++i)
    if (rows.contacts[i].restitution > 0.0) rows.rows[i].settled = speedAlong(rows, rows.rows[i]);
  return sweeps;
}

}  // namespace limber
