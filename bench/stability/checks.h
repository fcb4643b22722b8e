// SPDX-License-Identifier: Zlib
#pragma once

#include "bullet_soft/body_start.h"
#include "stability/hard_case.h"

namespace limber::bench {

// --- energy and momentum ---

/// The bodies' positions and velocities at one time.
struct BodyStates {
  std::vector<Eigen::Matrix3Xd> positions, velocities;  ///< #bodies
};

/// An energy (J) and a bound of its rounding error.
struct Energy {
  double value = 0.0, rounding = 0.0;
};

/// Computes energy and momentum of a case, by the same formulas for every engine, from positions and
/// velocities only.
///
///   E = sum m v^2 / 2                      points; movable rigid bodies: m v^2 / 2 + w I w / 2
///     + sum k (|xb - xa| - L)^2 / 2        springs
///     + sum m g (height above `lowest`)    points and movable rigid bodies
///
/// Work of other objects: static ones do no work. Kinematic bodies do while they press. So the balance starts
/// when they begin to leave (HardCase::energyFrom). From then on they can only push and move away: their work
/// is negative, and counts as 0. So E must never exceed its value at the start of the balance.
///
/// Bullet's positions and velocities have a relative rounding error of u (2^-24 in single precision). So the
/// error of a point at x is u |x|, that of a spring's length is d = u (|xa| + |xb|), and that of its energy,
/// for an elongation of e, is k (|e| d + d^2 / 2). The relative error of kinetic energies is 2 u; the error
/// of heights is u |x|.
class EnergyBalance {
 public:
  explicit EnergyBalance(const HardCase& hard);

  Energy energy(const BodyStates& states, const RigidBodies& rigid) const;
  Eigen::Vector3d momentum(const BodyStates& states) const;  ///< kg m/s, of the bodies' points
  double momentumScale(const BodyStates& states) const;      ///< kg m/s, sum m |v|
  const BodyStart& start(std::size_t body) const { return starts_[body]; }

 private:
  void addPoints(const BodyStates& states, std::size_t body, Energy& sum) const;
  void addSprings(const BodyStates& states, std::size_t body, Energy& sum) const;
  void addRigid(const btRigidBody& body, Energy& sum) const;
  void addPotential(double mass, const Eigen::Vector3d& x, Energy& sum) const;

  const HardCase& hard_;
  std::vector<BodyStart> starts_;  // #bodies
};

// --- shape ---

/// The final shape of a body.
enum class Shape : std::uint8_t {
  Rest,      ///< the rest shape, moved and rotated
  Mirrored,  ///< its mirror image, which is equivalent for the springs
  Other,     ///< another shape in stable equilibrium
  Saddle,    ///< a shape in unstable equilibrium: the exact motion stays there only if it starts there
  Spinning,  ///< it rotates so fast that the springs must be longer
  Lost       ///< none of these
};

const char* nameOf(Shape shape);

struct ShapeCheck {
  Shape shape = Shape::Lost;
  double error = 0.0;  ///< largest change of the distance of two points, as a fraction of `size`
};

constexpr double kShapeTolerance = 1e-3;

/// Input of checkShape.
struct ShapeQuestion {
  const BodySetup& setup;
  const BodyStart& start;
  const Eigen::Matrix3Xd &positions, &velocities;
  double size;  ///< m
  bool alone;   ///< no forces except those of its own springs
};

/// Compares all distances between two points with those of the rest shape. If they differ, finds the reason
/// for the other shape.
ShapeCheck checkShape(const ShapeQuestion& question);

/// Angular momentum (kg m^2/s) about the centre of mass, and the sum of m |r| |v| relative to the centre.
struct Spin {
  Eigen::Vector3d momentum = Eigen::Vector3d::Zero();
  double scale = 0.0;
};
Spin spinOf(const Eigen::VectorXd& masses, const Eigen::Matrix3Xd& x, const Eigen::Matrix3Xd& v);

}  // namespace limber::bench
