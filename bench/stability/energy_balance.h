// SPDX-License-Identifier: Zlib
#pragma once

#include "engines/body_start.h"
#include "stability/hard_case.h"

namespace limber::bench {

/// The bodies' positions and velocities at one moment.
struct BodyStates {
  std::vector<Eigen::Matrix3Xd> positions, velocities;  ///< #bodies
};

/// J, with what the rounding of the numbers it is read from may have made of it.
struct Energy {
  double value = 0.0, rounding = 0.0;
};

/// Energy and momentum of a case, by the same formulas for every engine, from positions and velocities alone.
///
///   E = sum m v^2 / 2                      points; movable rigid bodies: m v^2 / 2 + w I w / 2
///     + sum k (|xb - xa| - L)^2 / 2        springs
///     + sum m g (height above `lowest`)    points and movable rigid bodies
///
/// Work from outside: what is static does none. Kinematic bodies do, while they press; the balance is opened
/// when they start to leave (HardCase::energyFrom), and from then on their work is negative, since they can
/// only push and move away: it counts as 0. So E may never exceed what it was at the opening.
///
/// Bullet's positions and velocities are numbers with a relative rounding of u (2^-24 in single precision).
/// A point at x is so known to u |x|, the length of a spring to d = u (|xa| + |xb|), and with an elongation
/// of e its energy to k (|e| d + d^2 / 2); kinetic energies are known to 2 u and heights to u |x|.
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

}  // namespace limber::bench
