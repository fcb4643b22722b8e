// SPDX-License-Identifier: Zlib
#pragma once

// Contacts and joints between bodies that are stepped together, and the solver for all of them in a substep.

#include "solver/joint_block.h"
#include "solver/links.h"
#include "solver/plane_contacts.h"
#include "solver/team.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

namespace limber {

/// The impulse of a contact, or a change of it.
struct ContactImpulse {
  double along = 0.0;                                ///< N s, along the normal, 0 or more
  Eigen::Vector3d across = Eigen::Vector3d::Zero();  ///< N s, friction, across the normal

  ContactImpulse& operator*=(double factor) {
    along *= factor;
    across *= factor;
    return *this;
  }
};

/// A point on the surface of a body. Soft: a point mass, or a point of an edge or a triangle. Rigid: a point
/// with a moment arm from the centre of mass. World: a point of a static or kinematic object, which no
/// impulse moves.
struct ContactPoint {
  enum class Kind : std::uint8_t { Soft, Rigid, World } kind = Kind::World;
  std::uint32_t body = 0;                              ///< index into LinkedBodies::points or rigids
  std::uint32_t count = 1;                             ///< Soft: number of points, 1 to 3
  std::array<std::uint32_t, 3> point{};                ///< Soft
  std::array<double, 3> weight{1.0};                   ///< Soft, sum 1
  double massFactor = 1.0;                             ///< of the body's mass and inertia in this contact
  Eigen::Vector3d arm = Eigen::Vector3d::Zero();       ///< Rigid: m, from the centre of mass, world axes
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();  ///< m/s, at the tick's start; of the surface, in
                                                       ///< addition to the body's motion
  Eigen::Vector3d acceleration =
      Eigen::Vector3d::Zero();  ///< m/s^2, World: of a surface that turns; across the normal
};

/// A corner, or both ends of an edge, of an object at rest that touches an edge or triangle of a soft body.
struct HeldCorners {
  int count = 0;  ///< 0: none
  std::array<Eigen::Vector3d, 2> at{Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()};
  double radiusSum = 0.0;  ///< m
  double maxDepth = 0.0;   ///< m, RoundSupport::maxDepth; 0: not round
};

/// A round surface that supports an edge or triangle at its corners.
struct RoundSupport {
  double radius = 0.0;    ///< m, with the radius of the points
  double maxDepth = 0.0;  ///< m, to which the edge or triangle may be in it between its corners
};

/// Returns how deep (m) a point of an edge or triangle is in a round surface if its corners rest on it. With
/// its weights w_i, the lengths L_ij between the corners and the radius R, the squared distance from the
/// centre is R^2 - sum w_i w_j L_ij^2. `weights`: 3.
double sagging(const std::array<Eigen::Vector3d, 3>& corners, const double* weights,
               const RoundSupport& support);

/// Returns the depth (m) that the contact with this sagging may have: the sagging, so that it needs no
/// contact besides those of the corners, up to the maximum. Beyond that less, down to 0 at twice the maximum.
/// It has no steps: they would push the body out when a contact begins.
double allowedDepth(double sagging, const RoundSupport& support);

/// Two contact points whose gap along a normal must not become smaller than allowed, with Coulomb friction
/// across the normal. The impulses at the two points are equal and opposite, so linear momentum is conserved
/// to rounding. Angular momentum is also conserved where one side can balance the couple (see
/// alignContactPoints()).
struct Contact : ContactBase {
  ContactPoint a, b;
  double gap = 0.0;                                 ///< m between the surfaces; updated in each substep
  ContactImpulse positionImpulse, velocityImpulse;  ///< of the present substep; initially the warm start
  const PlaneContact* held = nullptr;  ///< for a point on a surface at rest: the plane that follows it
  HeldCorners corners;                 ///< for an edge or triangle: the corners over which it slides
  double spheres = 0.0;    ///< m, for two point masses, or a rigid side b that is a ball about its centre of
                           ///< mass: sum of the radii; the contact follows both sides
  bool ended = false;      ///< the contact has ended in this tick; its impulse still counts
  bool separates = false;  ///< bodies that have been placed into each other: its work is not limited
};

/// A row of a joint in the axes of its bodies, with which it turns: see turnJoints().
struct JointAxes {
  Eigen::Vector3d axis = Eigen::Vector3d::Zero(), axisB = Eigen::Vector3d::Zero();  ///< linearA, linearB
  Eigen::Vector3d armA = Eigen::Vector3d::Zero(), armB = Eigen::Vector3d::Zero();   ///< m
  Eigen::Vector3d angularA = Eigen::Vector3d::Zero(),
                  angularB = Eigen::Vector3d::Zero();  ///< what is not due to the arms
  bool shared = false;                                 ///< angularB is opposite to angularA
  bool opposite = false;                               ///< linearB is opposite to linearA
};

/// Where a row's force acts on its first body: at its own pivot, as in Bullet's rows, or at that of the
/// second.
enum class JointPivots { Own, Shared };

/// One row of a joint between rigid bodies, in the form of Bullet's constraints:
///     linearA . va + angularA . wa + linearB . vb + angularB . wb = speed,
/// enforced by an impulse between lower and upper along the same vectors.
struct JointConstraint {
  static constexpr std::uint32_t kHeld = static_cast<std::uint32_t>(-1);
  std::uint32_t a = kHeld, b = kHeld;  ///< indices into LinkedBodies::rigids; kHeld: an immovable side
  Eigen::Vector3d linearA, angularA, linearB, angularB;
  double speed = 0.0;       ///< m/s or rad/s
  double correction = 0.0;  ///< likewise, the part of it that moves positions and leaves no velocity
  double recovery = 0.0;    ///< m/s or rad/s, the part of `speed` by which an error is corrected
  double lower = -HUGE_VAL, upper = HUGE_VAL;  ///< N s or N m s, per substep
  double yielding = 0.0;  ///< speed that the row lacks, per that which its impulse alone makes (Bullet's cfm)
  bool isDriven = false;  ///< a motor or spring, which only pulls as hard as its limits
  std::uint32_t contact = kHeld;  ///< for rolling friction: index of its contact; else kHeld
  double rolling = 0.0;           ///< m, ratio of the limits to the normal impulse of the contact
  Eigen::Vector3d armA = Eigen::Vector3d::Zero(),
                  armB = Eigen::Vector3d::Zero();  ///< m, from the centres of mass to the joint's pivot
  double positionImpulse = 0.0,
         velocityImpulse = 0.0;  ///< of the present substep; initially the warm start

  bool isBilateral() const { return lower == -HUGE_VAL && upper == HUGE_VAL; }

  // Written by the step.
  JointAxes local;
  double curve = 0.0;     ///< m/s, what turning adds to the mean speed of the pivots in a drift
  double impulse = 0.0;   ///< sum over the tick
  double mass = 0.0;      ///< impulse per speed; 0: neither side can be moved
  double softness = 0.0;  ///< change of the speed per impulse
  double work = 0.0;      ///< J, of the impulses by which errors are corrected
  bool inBlock = false;   ///< one of JointBlock::rows
  double before = 0.0, change = 0.0, direction = 0.0;  ///< scratch of the solver
};

/// A velocity on which a contact depends and which it changes: of a point mass, or of a rigid body's centre.
struct ConstraintPoint {
  double* velocity;    ///< m/s, 3
  double share;        ///< weight in the contact's relative velocity; negative on side b
  double response[3];  ///< 1/kg per axis: velocity change per impulse on side a
};

/// Data to adjust the share of a ConstraintPoint, see alignContactPoints().
struct MomentArm {
  const double* position;     ///< m, 3; nullptr for a rigid body
  const double* inverseMass;  ///< 1/kg per axis
  double across[2];           ///< weights of the point's normal speed in the contact's two tangential speeds
  double response[3];         ///< 1/kg: velocity change per tangential impulse and `across`
};

/// An angular velocity on which a contact depends and which it changes.
struct ConstraintRotation {
  RigidState* body;
  std::uint32_t node;     ///< in IslandConstraints::nodes
  double inverseFactor;   ///< 1 / ContactPoint::massFactor
  double speeds[3][3];    ///< m/s per rad/s: along the normal and both tangents
  double response[3][3];  ///< rad/s per N s along the same axes, at the body's present rotation
};

/// Components along a contact's normal and its two tangents. Plain numbers: Eigen would store them one by one
/// and load them in pairs, which stalls the processor.
struct ContactVector {
  double n = 0.0, u = 0.0, v = 0.0;

  static ContactVector from(const Eigen::Vector3d& v) { return {v[0], v[1], v[2]}; }
  ContactVector& operator+=(const ContactVector& o) { return n += o.n, u += o.u, v += o.v, *this; }
  ContactVector& operator*=(double f) { return n *= f, u *= f, v *= f, *this; }
  double squaredNorm() const { return n * n + u * u + v * v; }
};

/// 1/kg, symmetric 3 x 3: speeds along a contact's normal and both tangents per impulse in each of these
/// directions. Plain numbers, for the same reason.
struct Mobility {
  double nn = 0.0, nu = 0.0, nv = 0.0, uu = 0.0, uv = 0.0, vv = 0.0;

  static Mobility from(const Eigen::Matrix3d& m) {
    return {m(0, 0), m(1, 0), m(2, 0), m(1, 1), m(1, 2), m(2, 2)};
  }

  Mobility& operator+=(const Mobility& o) {
    nn += o.nn, nu += o.nu, nv += o.nv, uu += o.uu, uv += o.uv, vv += o.vv;
    return *this;
  }
};

/// The side that balances the couple of tangential impulses at two points that are apart along the normal.
enum class Couple : std::uint8_t { None, Soft, Rigid };

/// A contact in the form that the sweeps use. What a sweep needs of the contacts that support others comes
/// first. Threads that sweep neighbouring rows share no cache line.
struct alignas(64) ContactConstraint : ContactTarget {
  static constexpr std::uint32_t kNoRow = static_cast<std::uint32_t>(-1);
  std::uint32_t firstPoint, firstOfB, endPoint, firstRotation, endRotation;
  std::uint32_t beside = kNoRow;  ///< another row of the same point, both with static or kinematic objects
  Couple couple;
  bool ofPoint, rigidA, restitutes;  ///< see isOfPoint(); side a is a rigid body; has a restitution
  bool aligned;       ///< its impulses act along one line at the present positions, see alignContactPoints()
  double axes[3][3];  ///< the normal and two tangents
  ContactVector surfaceSpeeds;  ///< m/s, part of the relative velocity due to kinematic objects
  double mass, mobility;        ///< kg along the normal, and its inverse; both 0: neither side can be moved
  ContactVector positionImpulse, velocityImpulse,
      impulse;               ///< N s, see Contact; `impulse` counts since the last change of the normal
  ContactVector before;      ///< N s, scratch of the solver
  double gap;                ///< m
  double softness;           ///< see kSoftness (contact_row.h)
  double maxWork;            ///< J, limits the removal of an overlap in a substep, or:
  double freeSpeed;          ///< m/s
  double acrossSoftness;     ///< 1/kg, speed per change of friction since the last substep
  double acrossMass[3];      ///< kg between the tangents, softness included: uu, uv, vv
  double acrossAlong[2];     ///< 1/kg, tangential speeds per normal impulse
  double slidingMass;        ///< kg, smallest eigenvalue of acrossMass
  double friction;           ///< coefficient
  double maxFriction;        ///< N s, radius of the friction cone
  double minFrictionChange;  ///< share of maxFriction, see kMinFrictionChange (contact_row.h)
  ContactVector change, direction;  ///< N s, scratch of the solver
  double closing = 0.0;             ///< m, by which turning features have closed it in the last substep
  double recoverySpeed;             ///< m/s, see ContactBase
  double workFactor;                ///< see kRecoveryWork (contact_row.h); 0: its work is not limited
  double pinned;                    ///< m, part of an overlap due to pinned points, not included in the gap
  double lastVelocity[3];  ///< m/s, of side a relative to b at the end of the last substep; of contacts
                           ///< with restitution
};

/// The changes of a sweep: the largest squared change of a velocity, and the sum of all as an energy.
struct SweepChange {
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
  void add(const SweepChange& o) {
    largest = std::max(largest, o.largest);
    energy += o.energy;
  }
  bool within(double tolerance) const { return largest <= tolerance * tolerance; }
};

/// What decides whether a sweep leaves out a row, apart from the row: most sweeps leave out most rows.
struct RowNodes {
  std::uint32_t a, b;        ///< see bodiesOf()
  std::uint32_t begin, end;  ///< in IslandConstraints::nodeOf, of the row's points
  bool isLeftOut;            ///< by the last sweep; the row's change and direction are 0
  bool isSupported;          ///< see IslandConstraints::supportOf
  bool knowsSupports;        ///< IslandConstraints::supported is known for its points
  bool isActive;             ///< takes part in the sweeps: has an impulse, or would be violated without one
};

/// What a row's impulse along the normal does by a point to the contact that supports the point.
struct SupportedPoint {
  double ratio;     ///< impulse that is passed on per impulse of the row
  double mobility;  ///< 1/kg, speed of the row per impulse of the row that is passed on
};

/// A point mass or rigid body that contacts change.
struct ConstraintNode {
  static constexpr std::uint32_t kNoSupport = static_cast<std::uint32_t>(-1);
  int changedIn;   ///< the last sweep that changed it by more than the tolerance
  double changed;  ///< m/s, bound of its change since then
};

/// Consecutive rows that one thread sweeps, see IslandConstraints::sets.
struct alignas(64) RowSet {
  std::uint32_t begin = 0, end = 0;
  Range following;                                ///< in IslandConstraints::following
  std::uint32_t activeCount = 0, sweptCount = 0;  ///< in `active` and `swept`, from `begin` on
  SweepChange change;                             ///< of the last sweep
};

/// The contacts and joints of an island, which couple its bodies in addition to springs.
struct IslandConstraints {
  std::vector<Contact> contacts;
  std::vector<JointConstraint> joints;
  bool empty() const { return contacts.empty() && joints.empty(); }

  // Written by the step.
  std::vector<ContactConstraint> rows;  ///< #contacts, in the order of their sets
  std::vector<std::uint32_t> order;     ///< #rows, the contact of each
  std::vector<RowNodes> rowNodes;       ///< #rows
  std::vector<ConstraintPoint> points;
  std::vector<MomentArm> momentArms;  ///< #points
  std::vector<std::uint32_t> nodeOf;  ///< #points
  std::vector<ConstraintNode> nodes;
  std::vector<std::uint32_t> supportOf;   ///< #points: the row by which the point lies on a static or
                                          ///< kinematic object, opposite to its own row; kNoSupport: none
  std::vector<SupportedPoint> supported;  ///< #points: of those in `supportOf`, see RowNodes::knowsSupports
  std::vector<ConstraintRotation> rotations;
  std::vector<RowSet> sets;              ///< small islands have one
  std::vector<Range> phases;             ///< of `sets`; the sets of a phase have no body in common
  std::vector<std::uint32_t> active;     ///< #rows, by sets: rows in the sweeps of the present stage
  std::vector<std::uint32_t> swept;      ///< likewise: those of them in the present sweep
  std::vector<std::uint32_t> following;  ///< by sets: rows that followContacts() updates
  std::vector<int> changedIn;  ///< #soft bodies, then #rigid bodies: the last sweep that changed a node of it
  std::vector<std::uint32_t> weights, slabs, byPlace;  ///< likewise, scratch of divideRows()
  std::vector<std::pair<const double*, std::uint32_t>>
      nodeTable;  ///< scratch: velocities and their nodes, hashed by address
  std::vector<std::pair<std::uint32_t, std::uint32_t>>
      anchored;  ///< body and point, sorted: points attached to immovable bodies
  std::vector<Eigen::Vector3d>
      scaledMasses;  ///< 1/kg, inverse masses of points in contacts with a massFactor
  JointBlock block;
  double time = 0.0;           ///< s, since the tick's start, of the present substep's middle
  bool turns = false;          ///< a contact has an acceleration
  bool restitutes = false;     ///< a contact has a restitution
  bool pressed = false;        ///< static or kinematic objects press rigid bodies
  double squaredMotion = 0.0;  ///< m^2/s^2, mean square of the island's velocities, see kRecoveryWork
  double tolerance = 1e-4;  ///< m/s; a solve ends when all row errors are smaller, or after kMaxSweeps; see
                            ///< also kExactSweeps (contact_solver.cpp)
};

/// The indices of a contact's bodies in IslandConstraints::changedIn; equal if only one side can move.
struct RowBodies {
  std::uint32_t a, b;
};

inline RowBodies bodiesOf(const Contact& c, const LinkedBodies& bodies) {
  using Kind = ContactPoint::Kind;
  const auto indexOf = [&](const ContactPoint& side) {
    return side.body + (side.kind == Kind::Rigid ? static_cast<std::uint32_t>(bodies.points.size()) : 0);
  };
  return {indexOf(c.a.kind == Kind::World ? c.b : c.a), indexOf(c.b.kind == Kind::World ? c.a : c.b)};
}

/// Computes the rows and their masses. Call it before the first substep of a tick, and when contacts have
/// changed within the tick (see finishConstraints).
void prepareConstraints(IslandConstraints& rows, LinkedBodies& bodies);

/// Updates the speeds of surfaces that turn. `time` (s): since the tick's start, of the coming substep's
/// middle.
void turnSurfaces(IslandConstraints& rows, double time);

/// Keeps the joints' rows in the axes of their bodies. Call it at the start of the tick, before
/// prepareConstraints().
void startTurning(IslandConstraints& rows, const LinkedBodies& bodies);

/// Turns the joints' rows with their bodies, before a solve. The impulses of a row must act at the pivots
/// where these are now: along lines that pass each other, they would change the angular momentum. `dt`: s, of
/// the coming drift; 0 before a solve of velocities.
void turnJoints(IslandConstraints& rows, const LinkedBodies& bodies, double dt, JointPivots pivots);

/// Changes the velocities of `bodies`, which are where they were at the start of the tick, by impulses of the
/// joints, until these hold at the present velocities alone. Motors, springs and rolling friction do nothing.
/// The rows turn with the bodies.
void holdJoints(IslandConstraints& rows, LinkedBodies& bodies);

/// Divides the rows of a large island into sets, by slabs across its longest axis: first the rows inside the
/// slabs, then those between neighbours. Sets `order`, `sets` and `phases`. They do not depend on the number
/// of threads. With joints or anchors, which act through many bodies at once, the rows are one set in the
/// order of the contacts.
void divideRows(IslandConstraints& rows, const LinkedBodies& bodies);

/// Numbers the point masses and rigid bodies of the rows in the order of the rows: sets `nodeOf`, `rowNodes`
/// and the number of `nodes`. Sets `supportOf`, and `beside` of the rows.
void numberNodes(IslandConstraints& rows, const LinkedBodies& bodies);

/// Calls visit(set) for all sets, for those of a phase at the same time.
template <class Visit>
void forEachSet(IslandConstraints& rows, Team& team, Visit visit) {
  for (const Range& phase : rows.phases)
    team.forEach(phase.end - phase.begin, [&](std::uint32_t i) { visit(rows.sets[phase.begin + i]); });
}

/// Calls visit(i) for all rows.
template <class Visit>
void forEachRow(IslandConstraints& rows, Team& team, Visit visit) {
  forEachSet(rows, team, [&](const RowSet& set) {
    for (std::uint32_t i = set.begin; i < set.end; ++i) visit(i);
  });
}

/// Returns the offset (m) of one sphere from another at their first touch within dt seconds, or else when
/// they are nearest in that time. Returns the present offset if they overlap. `radiusSum` is in m.
Eigen::Vector3d offsetWhenNearest(const Eigen::Vector3d& offset, const Eigen::Vector3d& velocity, double dt,
                                  double radiusSum);

/// Updates contacts with surfaces at rest and with rigid balls, and contacts between point masses, to the
/// present positions of the bodies. Call it before a drift of dt seconds, and with 0 before velocities are
/// solved: there, contacts that bounce keep their normal.
void followContacts(IslandConstraints& rows, const LinkedBodies& bodies, Team& team, double dt);

/// Updates the gaps for a drift of dt seconds.
void updateGaps(IslandConstraints& rows, Team& team, double dt);

/// Writes gaps and impulses back to the contacts. Call it after the last substep, or before contacts are
/// changed.
void finishConstraints(IslandConstraints& rows);

/// Whether side a is a single point mass and side b a static or kinematic object.
inline bool isOfPoint(const Contact& c) {
  return c.a.kind == ContactPoint::Kind::Soft && c.a.count == 1 && c.b.kind == ContactPoint::Kind::World;
}

/// Adjusts a contact between moving bodies so that its impulses act along one line at the present positions
/// and change no angular momentum. Used for contacts that are about to have an impulse: the contact points of
/// others are not known yet.
/// The velocities at the end of a substep and the positions of the next one are solved at the same positions:
/// a row that is aligned stays so until the bodies drift.
void alignContactPoints(IslandConstraints& rows, std::size_t index);

// --- the solve ---------------------------------------------------------------------------------------------

/// Computes impulses before a drift of dt seconds in a tick of length `tick` (s). After the drift no gap is
/// smaller than allowed, overlaps are smaller by a limited amount, friction has stopped as much sliding as it
/// can, and joints and anchors hold. Starts from the impulses of the last substep and uses projected
/// Gauss-Seidel sweeps with a nonsmooth nonlinear conjugate gradient step between them (Silcowitz, Niebe,
/// Erleben 2010, algorithm 2). Returns the number of sweeps.
int solvePositions(IslandConstraints& rows, LinkedBodies& bodies, Team& team, double dt, double tick);

/// Computes impulses after the second kick of a substep. Contacts that had a position impulse do not approach
/// (as in solveVelocities of plane_contacts.h), and anchored points have the velocities of their pivots.
/// Returns the number of sweeps.
int solveVelocities(IslandConstraints& rows, LinkedBodies& bodies, Team& team);

// --- rows
// ---------------------------------------------------------------------------------------------------

inline Contact& contactOf(IslandConstraints& rows, std::size_t row) { return rows.contacts[rows.order[row]]; }
inline const Contact& contactOf(const IslandConstraints& rows, std::size_t row) {
  return rows.contacts[rows.order[row]];
}

/// Calls visit(rigid, linear, angular) for each side of the joint that can move.
template <class Rigids, class Visit>
void forEachSide(Rigids& rigids, const JointConstraint& j, Visit visit) {
  if (j.a != JointConstraint::kHeld) visit(rigids[j.a], j.linearA, j.angularA);
  if (j.b != JointConstraint::kHeld) visit(rigids[j.b], j.linearB, j.angularB);
}

}  // namespace limber
