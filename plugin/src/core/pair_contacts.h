// SPDX-License-Identifier: Zlib
#pragma once

#include "core/links.h"

#include <array>
#include <cstdint>
#include <vector>

namespace limber {

/// A place on the surface of a body: on a soft one a point mass or a place between two or three, on a rigid
/// one a place off its centre of mass, or one that moves as told.
struct SurfacePlace {
  enum class Kind : std::uint8_t { Soft, Rigid, World } kind = Kind::World;
  std::uint32_t body = 0;                              ///< index into the group's points or rigids
  std::uint32_t count = 1;                             ///< of a Soft: how many points, 1 to 3
  std::array<std::uint32_t, 3> point{};                ///< of a Soft
  std::array<double, 3> weight{1.0};                   ///< of a Soft, sum 1
  Eigen::Vector3d arm = Eigen::Vector3d::Zero();       ///< of a Rigid: m, from its centre, world axes
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();  ///< of the World: m/s, constant over the tick
};

/// Two places that must not get nearer to each other along a normal than they are allowed to, with Coulomb
/// friction across it. Impulses are equal and opposite at the two places, so linear momentum is kept to
/// rounding, and angular momentum as far as the places coincide.
struct PairContact {
  SurfacePlace a, b;
  Eigen::Vector3d normal = Eigen::Vector3d::UnitY();  ///< unit, from b to a
  double gap = 0.0;                                   ///< m between the surfaces; moves on with the substeps
  double friction = 0.0;
  double recoverySpeed = 0.5;  ///< m/s, at which surfaces that overlap are drawn apart at most

  // Written by the step.
  Eigen::Vector3d impulse = Eigen::Vector3d::Zero();  ///< N s on a, sum over the tick
  struct Bearing {
    double along = 0.0;                                ///< N s, 0 or more
    Eigen::Vector3d across = Eigen::Vector3d::Zero();  ///< N s, friction
  } stopping, settling;                                ///< of the present substep, and its start values
  double mass = 0.0;                                   ///< kg along the normal; 0: neither side can be moved
  double acrossMass = 0.0;                             ///< kg across it, the smallest of all directions
};

/// Before the first substep of a tick: the contacts' masses; forgets earlier impulses.
void preparePairs(std::vector<PairContact>& contacts, const LinkedBodies& bodies);

/// Before a drift of dt seconds: impulses with which no pair ends nearer than it may, those that overlap draw
/// apart gently, and friction stops as much sliding as it can. Projected Gauss-Seidel over all contacts,
/// from the impulses of the last substep on, until no contact changes a velocity by more than `tolerance`
/// (m/s); returns the number of sweeps.
int stopPairs(std::vector<PairContact>& contacts, LinkedBodies& bodies, double dt, double tolerance);

/// After that drift: the gaps as they are now.
void movePairs(std::vector<PairContact>& contacts, const LinkedBodies& bodies, double dt);

/// After the second kick of a substep: pairs that bore something do not approach, as settleContacts.
int settlePairs(std::vector<PairContact>& contacts, LinkedBodies& bodies, double tolerance);

}  // namespace limber
