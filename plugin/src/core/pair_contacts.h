// SPDX-License-Identifier: Zlib
#pragma once

#include "core/contact_place.h"

#include <cmath>
#include <cstdint>
#include <vector>

namespace limber {

/// What a contact bears, or a change of it.
struct Bearing {
  double along = 0.0;                                ///< N s, 0 or more
  Eigen::Vector3d across = Eigen::Vector3d::Zero();  ///< N s, friction

  Bearing& operator*=(double factor) {
    along *= factor;
    across *= factor;
    return *this;
  }
  Bearing& operator+=(const Bearing& other) {
    along += other.along;
    across += other.across;
    return *this;
  }
};

/// Two places that must not get nearer to each other along a normal than they are allowed to, with Coulomb
/// friction across it. Impulses are equal and opposite at the two places, so linear momentum is kept to
/// rounding, and angular momentum as far as the places coincide.
struct PairContact {
  ContactPlace a, b;
  Eigen::Vector3d normal = Eigen::Vector3d::UnitY();  ///< unit, from b to a
  double gap = 0.0;                                   ///< m between the surfaces; moves on with the substeps
  double friction = 0.0;
  double restitution = 0.0;    ///< of speeds of approach above kLeastBounce
  double recoverySpeed = 0.5;  ///< m/s, at which surfaces that overlap are drawn apart at most
  Bearing stopping, settling;  ///< of the present substep; to begin with, a guess

  // Written by the step.
  Eigen::Vector3d impulse = Eigen::Vector3d::Zero();  ///< N s on a, sum over the tick
  double mass = 0.0;                                  ///< kg along it; 0: neither side can be moved
  Eigen::Matrix<double, 3, 2> tangents = Eigen::Matrix<double, 3, 2>::Zero();  ///< across the normal
  Eigen::Matrix2d acrossMass = Eigen::Matrix2d::Zero();                        ///< kg, between the tangents
  Eigen::Vector2d acrossAlong = Eigen::Vector2d::Zero();  ///< 1/kg, speeds across per impulse along
  double bounce = 0.0;                ///< m/s, at which they must part in the present substep
  Bearing before, change, direction;  ///< scratch of the solver
};

/// One row of a joint between rigid bodies, as Bullet's constraints describe theirs:
///     linearA . va + angularA . wa + linearB . vb + angularB . wb = speed,
/// kept by an impulse between lower and upper that acts along those same vectors.
struct JointRow {
  static constexpr std::uint32_t kHeld = static_cast<std::uint32_t>(-1);
  std::uint32_t a = kHeld, b = kHeld;  ///< indices into the group's rigids; kHeld: nothing moves it
  Eigen::Vector3d linearA, angularA, linearB, angularB;
  double speed = 0.0;                          ///< m/s or rad/s
  double lower = -HUGE_VAL, upper = HUGE_VAL;  ///< N s or N m s, of a substep
  double softness = 0.0;                       ///< of the speed, per impulse (Bullet's cfm / time step)
  double stopping = 0.0, settling = 0.0;       ///< impulse of the present substep; to begin with, a guess

  // Written by the step.
  double impulse = 0.0;                  ///< sum over the tick
  double mass = 0.0;                     ///< impulse per speed; 0: neither side can be moved
  double change = 0.0, direction = 0.0;  ///< scratch of the solver
};

/// m/s: slower approaches do not bounce, or nothing would come to rest (Bullet's own threshold).
constexpr double kLeastBounce = 0.2;

/// What couples the bodies of a group besides springs.
struct PairRows {
  std::vector<PairContact> contacts;
  std::vector<JointRow> joints;
  bool empty() const { return contacts.empty() && joints.empty(); }
};

/// Before the first substep of a tick: masses; forgets earlier sums.
void preparePairs(PairRows& rows, const LinkedBodies& bodies);

/// After a drift of dt seconds: the gaps as they are now.
void movePairs(PairRows& rows, const LinkedBodies& bodies, double dt);

/// Gives both sides an impulse.
void bear(LinkedBodies& bodies, PairContact& c, const Bearing& change);
void bear(LinkedBodies& bodies, JointRow& j, double change);

/// Brings the speed along the normal up to `target` (m/s), with the impulse `sum` 0 or more and friction
/// within its cone; c.change is what this has changed.
void solveContact(LinkedBodies& bodies, PairContact& c, Bearing& sum, double target);

/// Brings the joint to its speed, with the impulse `sum` within its limits; j.change likewise.
void solveJoint(LinkedBodies& bodies, JointRow& j, double& sum);

}  // namespace limber
