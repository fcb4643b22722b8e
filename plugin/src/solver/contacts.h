// SPDX-License-Identifier: Zlib
#pragma once

// Contacts and joints between bodies that are stepped together, and the solve of all of them in a substep.

#include "solver/links.h"
#include "solver/plane_contacts.h"
#include "solver/point_state.h"

#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

namespace limber {

/// What a contact bears, or a change of it.
struct ContactImpulse {
  double along = 0.0;                                ///< N s, 0 or more
  Eigen::Vector3d across = Eigen::Vector3d::Zero();  ///< N s, friction

  ContactImpulse& operator*=(double factor) {
    along *= factor;
    across *= factor;
    return *this;
  }
  ContactImpulse& operator+=(const ContactImpulse& other) {
    along += other.along;
    across += other.across;
    return *this;
  }
};

/// A place on the surface of a body: on a soft one a point mass or a place between two or three, on a rigid
/// one a place off its centre of mass, or one that nothing moves but as told.
struct ContactPoint {
  enum class Kind : std::uint8_t { Soft, Rigid, World } kind = Kind::World;
  std::uint32_t body = 0;                              ///< index into the group's points or rigids
  std::uint32_t count = 1;                             ///< of a Soft: how many points, 1 to 3
  std::array<std::uint32_t, 3> point{};                ///< of a Soft
  std::array<double, 3> weight{1.0};                   ///< of a Soft, sum 1
  Eigen::Vector3d arm = Eigen::Vector3d::Zero();       ///< of a Rigid: m, from its centre, world axes
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();  ///< of the World: m/s, constant over the tick
};

/// A corner, or an edge's ends, of something at rest that an edge or a triangle of a soft body touches.
struct HeldCorners {
  int count = 0;  ///< 0: none
  std::array<Eigen::Vector3d, 2> at{Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()};
  double radiusSum = 0.0;  ///< m, both radii
};

/// Two places that must not get nearer to each other along a normal than they are allowed to, with Coulomb
/// friction across it. Impulses are equal and opposite at the two places, so linear momentum is kept to
/// rounding; angular momentum, too, where one side can bear the couple (see joinPlaces() of
/// contact_solver.cpp).
struct Contact {
  ContactPoint a, b;
  Eigen::Vector3d normal = Eigen::Vector3d::UnitY();  ///< unit, from b to a
  double gap = 0.0;                                   ///< m between the surfaces; moves on with the substeps
  double friction = 0.0;
  double restitution = 0.0;
  double bounceThreshold = 0.0;     ///< m/s, slower approaches do not bounce
  double recoverySpeed = HUGE_VAL;  ///< m/s, at which surfaces that overlap are drawn apart at most
  ContactImpulse positionImpulse, velocityImpulse;  ///< of the present substep; to begin with, a guess
  const PlaneContact* held = nullptr;  ///< of a point on a surface at rest: the row that follows it
  HeldCorners corners;                 ///< of an edge or triangle: what it slides over
  double spheres = 0.0;                ///< m, of two point masses: both radii; the contact follows them
  bool ended = false;                  ///< no longer there, but what it bore in this tick still is

  // Written by the step.
  TickImpulse impulse;  ///< on a; while rows are prepared, without what they bore since their normal turned
};

/// One row of a joint between rigid bodies, as Bullet's constraints describe theirs:
///     linearA . va + angularA . wa + linearB . vb + angularB . wb = speed,
/// kept by an impulse between lower and upper that acts along those same vectors.
struct JointConstraint {
  static constexpr std::uint32_t kHeld = static_cast<std::uint32_t>(-1);
  std::uint32_t a = kHeld, b = kHeld;  ///< indices into the group's rigids; kHeld: nothing moves it
  Eigen::Vector3d linearA, angularA, linearB, angularB;
  double speed = 0.0;                          ///< m/s or rad/s
  double lower = -HUGE_VAL, upper = HUGE_VAL;  ///< N s or N m s, of a substep
  double softness = 0.0;                       ///< of the speed, per impulse (Bullet's cfm / time step)
  std::uint32_t contact = kHeld;               ///< rolling friction: of which contact; else kHeld
  double rolling = 0.0;                        ///< m, its limits are so many times what the contact bears
  double positionImpulse = 0.0,
         velocityImpulse = 0.0;  ///< impulse of the present substep; to begin with, a guess

  // Written by the step.
  double impulse = 0.0;                  ///< sum over the tick
  double mass = 0.0;                     ///< impulse per speed; 0: neither side can be moved
  double change = 0.0, direction = 0.0;  ///< scratch of the solver
};

/// A velocity that a contact depends on and changes: of a point mass, or of a rigid body's centre.
struct ConstraintPoint {
  double* velocity;    ///< m/s, 3
  double share;        ///< of it in the contact's speed; below 0 on side b
  double response[3];  ///< 1/kg per axis: its change per impulse on side a
};

/// What makes a ConstraintPoint's share follow the place where two bodies touch, see joinPlaces() of
/// contact_solver.cpp.
struct MomentArm {
  const double* position;     ///< m, 3; none of a rigid body
  const double* inverseMass;  ///< 1/kg per axis
  double across[2];           ///< of the point's speed along the normal, in the contact's two across it
  double response[3];         ///< 1/kg: its change per impulse across and `across`
};

/// An angular velocity that a contact depends on and changes.
struct ConstraintRotation {
  RigidState* body;
  double speeds[3][3];    ///< m/s per rad/s: along, across and across both
  double response[3][3];  ///< rad/s per N s along, across and across both, as the body is turned now
};

/// Along a contact's normal, across it and across both. Plain numbers: Eigen would store them one by one and
/// load them in pairs, for which the processor waits.
struct ContactVector {
  double n = 0.0, u = 0.0, v = 0.0;

  ContactVector& operator+=(const ContactVector& o) { return n += o.n, u += o.u, v += o.v, *this; }
  ContactVector& operator*=(double f) { return n *= f, u *= f, v *= f, *this; }
  double squaredNorm() const { return n * n + u * u + v * v; }
};

/// Who bears the couple of what is across a contact, whose two places are apart along its normal.
enum class Couple : std::uint8_t { Nobody, Soft, Rigid };

/// A contact as the sweeps want it.
struct ContactConstraint {
  double axes[3][3];      ///< the normal and two tangents
  ContactVector carried;  ///< m/s, of what is moved as told
  std::uint32_t firstPoint, firstOfB, endPoint, firstRotation, endRotation;
  Couple couple;
  double gap, target;         ///< m; m/s, along it at least
  double pinned;              ///< m, what pinned points have of an overlap, which is not in the gap
  double rebound;             ///< m/s, if it bounces, see Bounce (plane_contacts.h)
  double settled;             ///< m/s along it, when the last substep ended
  double softness;            ///< see kSoftness
  double mass, mobility;      ///< kg along it, and its inverse; both 0: neither side can be moved
  double acrossSoftness;      ///< 1/kg, speed per change of friction since the last substep
  double acrossMass[3];       ///< kg between the tangents, softness included: uu, uv, vv
  double acrossAlong[2];      ///< 1/kg, speeds across per impulse along
  double turnMass, friction;  ///< kg, the least of acrossMass; coefficient
  double maxFriction;         ///< N s, the radius of its cone
  bool bounces;               ///< in this substep
  bool active;                ///< it bears something, or would be crossed
  ContactVector positionImpulse, velocityImpulse,
      impulse;                              ///< N s, see Contact; the last since the normal turned
  ContactVector before, change, direction;  ///< N s, scratch of the solver
};

/// What couples the bodies of a group besides springs.
struct IslandConstraints {
  std::vector<Contact> contacts;
  std::vector<JointConstraint> joints;
  bool empty() const { return contacts.empty() && joints.empty(); }

  // Written by the step.
  std::vector<ContactConstraint> rows;  ///< #contacts
  std::vector<ConstraintPoint> points;
  std::vector<MomentArm> momentArms;  ///< #points
  std::vector<ConstraintRotation> rotations;
  std::vector<std::uint32_t> active;  ///< rows of the present stage
  std::vector<std::pair<std::uint32_t, std::uint32_t>>
      carried;              ///< body and point, sorted: attached to what is held
  double tolerance = 1e-4;  ///< m/s, no row may be wrong by more when a solve ends, if it has sweeps left
};

/// Before the first substep of a tick, and when contacts have changed within it (see finishConstraints):
/// rows, masses. The state of bodies.points[i] is at views[i].
void prepareConstraints(IslandConstraints& rows, LinkedBodies& bodies, const std::vector<PointView>& views);

/// Makes the row's masses those that belong to speeds per impulse (1/kg), along, across and across both.
void setMobility(ContactConstraint& row, const Eigen::Matrix3d& mobility);

/// Where one sphere is relative to another when they touch on a straight way of dt seconds, or else when they
/// are nearest; m and m/s, `radiusSum` is the sum of their radii. Now, if they overlap.
Eigen::Vector3d offsetWhenNearest(const Eigen::Vector3d& offset, const Eigen::Vector3d& velocity, double dt,
                                  double radiusSum);

/// Makes contacts on what is at rest, and those of point masses with each other, those of where the soft
/// bodies are now, before a drift of dt seconds.
void followContacts(IslandConstraints& rows, double dt);

/// After a drift of dt seconds: the gaps as they are now.
void updateGaps(IslandConstraints& rows, double dt);

/// After the last substep, or before contacts are changed: their gaps and what they bore.
void finishConstraints(IslandConstraints& rows);

/// Makes the responses of rigid bodies those of their present rotation.
void rotateResponses(IslandConstraints& rows);

void applyImpulse(LinkedBodies& bodies, JointConstraint& j, double change);

/// Brings the joint to its speed, with the impulse `sum` within its limits; j.change likewise.
void solveJoint(LinkedBodies& bodies, JointConstraint& j, double& sum);

// --- the solve ---------------------------------------------------------------------------------------------

/// Before a drift of dt seconds in a tick of that length: impulses with which no pair ends nearer than it
/// may, those that overlap draw apart gently, friction stops as much sliding as it can, and joints and
/// anchors hold. From the impulses of the last substep on, by projected Gauss-Seidel sweeps with a nonsmooth
/// nonlinear conjugate gradient step between them (Silcowitz, Niebe, Erleben 2010, algorithm 2). Returns the
/// number of sweeps.
int solvePositions(IslandConstraints& rows, LinkedBodies& bodies, double dt, double tick);

/// After the second kick of a substep: pairs that bore something do not approach, as solveVelocities, and the
/// velocities of anchored points are those of their pivots.
int solveVelocities(IslandConstraints& rows, LinkedBodies& bodies);

}  // namespace limber
