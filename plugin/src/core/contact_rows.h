// SPDX-License-Identifier: Zlib
#pragma once

#include "core/point_view.h"

#include <cstdint>
#include <vector>

namespace limber {

/// A point mass above a surface that nothing moves (static), or that moves as told (kinematic): the point's
/// centre must stay on the outer side of a plane, and slides on it with Coulomb friction.
///
///     gap(t) = normal . (x(t) - touch - t surfaceVelocity) >= 0,    t from the start of the tick
struct ContactRow {
  std::uint32_t point = 0;
  Eigen::Vector3d normal = Eigen::Vector3d::UnitY();  ///< unit, from the surface to the point
  Eigen::Vector3d touch = Eigen::Vector3d::Zero();    ///< m, where the centre touches at the tick's start
  Eigen::Vector3d surfaceVelocity = Eigen::Vector3d::Zero();  ///< m/s, constant over the tick
  double friction = 0.0;
  double restitution = 0.0;    ///< of speeds of approach above kLeastBounce
  double recoverySpeed = 0.5;  ///< m/s, at which a point that is below the surface is lifted at most
  bool coupled = false;        ///< it is solved elsewhere, with contacts between bodies (pair_contacts.h)

  // Written by the step.
  double mass = 0.0;                                  ///< kg along the normal; 0: cannot be moved
  Eigen::Vector3d impulse = Eigen::Vector3d::Zero();  ///< N s on the point, sum over the tick
  bool touching = false;                              ///< it bore something in the present substep
  double target = 0.0;                                ///< m/s along the normal at least, in this substep
};

/// The indices of a point's rows, among rows in the order of their points.
struct RowRange {
  std::size_t begin, end;
};
RowRange rowsOfPoint(const std::vector<ContactRow>& rows, std::uint32_t point);

/// m/s: slower approaches do not bounce, or nothing would come to rest (Bullet's own threshold).
constexpr double kLeastBounce = 0.2;

/// Share of a penetration taken back per substep, up to recoverySpeed: a body that was placed inside
/// something must come out, not be thrown out.
constexpr double kRecovery = 0.2;

/// Before the first substep of a tick: the rows' masses.
void prepareContacts(std::vector<ContactRow>& rows, const PointView& points);

/// Before a drift of `dt` from `time` (s since the start of the tick): takes from each point the velocity
/// with which it would end below a surface, and as much of its sliding as friction allows. A point that is
/// already below is lifted gently. Rows of one point alternate until they agree; rows of different points are
/// independent, so this is exact.
void stopAtContacts(std::vector<ContactRow>& rows, const PointView& points, double time, double dt);

/// After the second kick of a substep: a point that touches does not approach. This is to stopAtContacts what
/// RATTLE is to SHAKE: velocities are those of bodies at rest, not of a step in free fall.
void settleContacts(std::vector<ContactRow>& rows, const PointView& points);

}  // namespace limber
