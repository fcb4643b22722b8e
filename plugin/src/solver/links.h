// SPDX-License-Identifier: Zlib
#pragma once

// Springs and anchors between soft and rigid bodies, and the rigid bodies that they join.

#include "solver/point_state.h"

#include <Eigen/Geometry>

#include <cstdint>
#include <vector>

namespace limber {

// --- rigid bodies ------------------------------------------------------------------------------------------

/// Returns the matrix of the cross product with v:  crossMatrix(v) w = v x w.
inline Eigen::Matrix3d crossMatrix(const Eigen::Vector3d& v) {
  Eigen::Matrix3d cross;
  cross << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return cross;
}

/// A rigid body that springs or anchors join to soft bodies; it moves in their substeps.
struct RigidState {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< m, of the centre of mass
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();             ///< m/s
  Eigen::Vector3d angularVelocity = Eigen::Vector3d::Zero();      ///< rad/s
  Eigen::Vector3d acceleration = Eigen::Vector3d::Zero();         ///< m/s^2, constant over a tick
  Eigen::Vector3d angularAcceleration = Eigen::Vector3d::Zero();  ///< rad/s^2, constant over a tick
  Eigen::Vector3d inverseMass = Eigen::Vector3d::Zero();          ///< 1/kg per axis; 0: held or static
  Eigen::Vector3d inverseInertiaLocal = Eigen::Vector3d::Zero();  ///< 1/(kg m^2), principal axes
  Eigen::Vector3d angularFactor = Eigen::Vector3d::Ones();        ///< 0 locks a world axis
  bool gyroscopic = false;  ///< its unequal moments of inertia change its angular velocity
  bool isFrame = false;     ///< stands for a soft body, whose points have its mass: see BodyFrame
  Eigen::Vector3d force = Eigen::Vector3d::Zero();           ///< N, from springs
  Eigen::Vector3d torque = Eigen::Vector3d::Zero();          ///< N m, from springs
  Eigen::Matrix3d inverseInertia = Eigen::Matrix3d::Zero();  ///< 1/(kg m^2), about world axes, see turn()

  /// Updates inverseInertia to the present rotation. Call it once the fields above are set; drift() calls it.
  void turn();

  void kick(double dt);
  void drift(double dt);

  /// Returns the rotation after `dt` (s) without torques: with constant angular velocity, or if gyroscopic
  /// with constant angular momentum.
  Eigen::Quaterniond rotationAfter(double dt) const;

  /// kg m^2/s, of a body whose moments of inertia are all finite.
  Eigen::Vector3d angularMomentum() const;

  /// Adds an impulse (N s) at `arm` (m) from the centre of mass.
  void applyImpulse(const Eigen::Vector3d& impulse, const Eigen::Vector3d& arm) {
    velocity += impulse.cwiseProduct(inverseMass);
    angularVelocity += inverseInertia * arm.cross(impulse);
  }

  Eigen::Vector3d velocityAt(const Eigen::Vector3d& arm) const {
    return velocity + angularVelocity.cross(arm);
  }

  /// 1/kg, 3 x 3: the velocity change at `arm` per impulse there.
  Eigen::Matrix3d mobilityAt(const Eigen::Vector3d& arm) const {
    const Eigen::Matrix3d cross = crossMatrix(arm);
    Eigen::Matrix3d m = -cross * inverseInertia * cross;
    m.diagonal() += inverseMass;
    return m;
  }
};

/// Returns the rotation by |v| radians about v.
Eigen::Quaterniond rotationBy(const Eigen::Vector3d& v);

/// Returns the vector of the rotation from `from` to `to`, at most pi long.
Eigen::Vector3d rotationBetween(const Eigen::Quaterniond& from, const Eigen::Quaterniond& to);

// --- links -------------------------------------------------------------------------------------------------

/// An end of a link: a point mass of a soft body, a pivot on a rigid body, or a point in the world.
struct LinkEnd {
  enum class Kind : std::uint8_t { Point, Rigid, World } kind = Kind::World;
  std::uint32_t body = 0;                           ///< index into LinkedBodies::points or rigids
  std::uint32_t point = 0;                          ///< for a Point
  Eigen::Vector3d pivot = Eigen::Vector3d::Zero();  ///< m; local to a Rigid, in world coordinates for World
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();  ///< m/s of a World end, constant over a tick
};

/// A single spring between two ends, with the properties of SpringSettings.
struct LinkSpring {
  LinkEnd a, b;
  double restLength = 0.0, extensionStiffness = 0.0, compressionStiffness = 0.0, damping = 0.0;
  double squaredLength = 0.0;                           ///< m^2, at the last forces
  Eigen::Vector3d direction = Eigen::Vector3d::Zero();  ///< from a to b, while it is taut
  double force = 0.0;                                   ///< N, positive: pulls
};

/// A point mass that moves with a pivot on a rigid body.
struct LinkAnchor {
  LinkEnd point;  ///< of kind Point
  LinkEnd pivot;  ///< of kind Rigid
  Eigen::Vector3d positionImpulse =
      Eigen::Vector3d::Zero();  ///< N s on the point in the present substep, before
  Eigen::Vector3d velocityImpulse =
      Eigen::Vector3d::Zero();  ///< its drift and after it; initially the warm start

  // Written by the step.
  Eigen::Vector3d impulse = Eigen::Vector3d::Zero();  ///< N s on the point, sum over the tick
  Eigen::Vector3d apart = Eigen::Vector3d::Zero();    ///< m, target offset of the point from the pivot
  Eigen::Vector3d arm = Eigen::Vector3d::Zero();      ///< m, of the pivot from the centre of mass
  Eigen::Matrix3d mass = Eigen::Matrix3d::Zero();     ///< kg, impulse on the point per velocity
  bool held = false;                                  ///< no impulse moves the rigid body
  Eigen::Vector3d drifted = Eigen::Vector3d::Zero();  ///< m, of a held pivot after the drift
  Eigen::Vector3d speed = Eigen::Vector3d::Zero();    ///< m/s, of a held pivot
  Eigen::Vector3d error = Eigen::Vector3d::Zero();    ///< m/s, see AnchorSet
  Eigen::Vector3d direction = Eigen::Vector3d::Zero(), change = Eigen::Vector3d::Zero();  ///< scratch
};

/// Anchors that are solved together: all on one rigid body whose points can move, or a single one.
///
/// One after the other they would need the more sweeps the heavier the points are beside the body, and an
/// unfinished solve feeds its rest into the next one: points of nineteen times the body's moment of inertia
/// exploded. Together they have one solution. With the error e_i of an anchor (its point's velocity less that
/// of its pivot), the mass m_i of its point, J_i = [1, -r_i x] and the body's mass matrix M, the impulses are
///     l_i = -m_i (e_i + J_i u),   (M + sum J_i^T m_i J_i) u = -sum J_i^T m_i e_i,
/// where the body's velocity changes by -u.
struct AnchorSet {
  std::uint32_t begin = 0, end = 0;  ///< in LinkedBodies::anchorOrder
  Eigen::Matrix<double, 6, 6> solve =
      Eigen::Matrix<double, 6, 6>::Zero();  ///< u per  -sum J_i^T m_i e_i;  of sets of several
  bool isSingle() const { return end - begin == 1; }
};

/// A soft body as a whole, on which joints act like on a rigid body: it has the mass, inertia, momentum and
/// angular momentum of the points that are not held, and its impulses move all of them as a rigid body moves.
/// About a line on which all points lie it turns on its own: the points bear no torque there.
struct BodyFrame {
  std::uint32_t body = 0;   ///< index into LinkedBodies::points
  std::uint32_t rigid = 0;  ///< index into LinkedBodies::rigids
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero(),
                  spin = Eigen::Vector3d::Zero();  ///< m/s and rad/s of the rigid body that the points have
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();  ///< kg m^2, about world axes
  std::uint32_t begin = 0, end = 0;                   ///< in LinkedBodies::framePoints
};

/// A point of a BodyFrame that is not held.
struct FramePoint {
  std::uint32_t point;
  double mass;          ///< kg
  Eigen::Vector3d arm;  ///< m, from the centre of mass
};

/// Soft and rigid bodies that links join and that are stepped together.
struct LinkedBodies {
  std::vector<PointState*> points;
  std::vector<PointView> views;  ///< during a step: where it has the points of each body; else empty
  std::vector<RigidState> rigids;
  std::vector<BodyFrame> frames;
  std::vector<FramePoint> framePoints;  ///< written by fitFrames()
  std::vector<LinkSpring> springs;
  std::vector<LinkAnchor> anchors;

  std::vector<std::uint32_t> taut;  ///< written by addLinkForces(): the springs that are not slack

  // Written by prepareAnchors().
  std::vector<AnchorSet> anchorSets;
  std::vector<std::uint32_t> anchorOrder;  ///< #anchors, by sets

  // Scratch of linkFrequencyBoundSquared.
  std::vector<double> stiffnessSums;       ///< #rigids, then #points of all bodies
  std::vector<std::size_t> firstOfPoints;  ///< #points, index of each body's first point in stiffnessSums
};

/// Adds the force of every link to both its ends, and stores its direction and which are taut.
void addLinkForces(LinkedBodies& bodies, double dt, double crossing);

/// Moves the ends in the world for `dt` seconds.
void driftLinks(LinkedBodies& bodies, double dt);

/// Adds the anchors' impulses of a substep to those of the tick.
void sumAnchorImpulses(LinkedBodies& bodies);

/// Applies the dampers of the taut links for `dt` seconds, see dampingImpulse().
void dampLinks(LinkedBodies& bodies, double dt, bool forward);

/// Returns the links' addition (rad^2/s^2) to the bound of the fastest oscillation (frequencyBoundSquared,
/// with the inverse mass of a rigid body at a pivot, 1/m + |r|^2 / smallest inertia).
double linkFrequencyBoundSquared(LinkedBodies& bodies);

/// Divides the anchors into sets, finds those on bodies that no impulse moves, computes their masses and
/// clears the impulses of all. Call it before a step.
void prepareAnchors(LinkedBodies& bodies);

/// Updates the anchors and their sets to the present rotation of the rigid bodies: the masses, or the speeds
/// of held pivots.
void updateAnchors(LinkedBodies& bodies);

/// Sets the target error of each anchor after a drift of `dt` in a tick of length `tick` (s). Errors are
/// removed slowly: Bullet moves a body once a tick, and removing that displacement in one substep would
/// multiply the speed by the number of substeps.
void aimAnchors(LinkedBodies& bodies, double dt, double tick);

/// Sets `error` (m/s) of the set's anchors, and `change` to the impulses that remove it. Without error the
/// points are `apart` from their pivots after a drift of `dt` (SHAKE), or for dt = 0 have their velocities
/// (RATTLE; Andersen 1983).
void findChanges(LinkedBodies& bodies, const AnchorSet& set, double dt);

/// Applies an impulse to the point and its opposite to the rigid body.
void applyImpulse(LinkedBodies& bodies, const LinkAnchor& anchor, const Eigen::Vector3d& impulse);

/// Makes the velocities of points and pivots equal, without regard to contacts.
void joinVelocities(LinkedBodies& bodies);

/// Gives the frames' rigid bodies the place, mass, inertia and velocities of the points.
void fitFrames(LinkedBodies& bodies);

/// Gives them the velocities of the points, which are where they were at the last fitFrames().
void fitFrameVelocities(LinkedBodies& bodies);

/// Gives the points the changes of the rigid bodies' velocities since the last fit.
void pushFrames(LinkedBodies& bodies);

/// Returns the world position (m) of an end.
Eigen::Vector3d endPosition(const LinkedBodies& bodies, const LinkEnd& end);

/// Returns the energy (J) stored in the links.
double elasticEnergy(const LinkedBodies& bodies);

}  // namespace limber
