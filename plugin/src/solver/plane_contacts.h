// SPDX-License-Identifier: Zlib
#pragma once

#include "solver/held_surface.h"
#include "solver/point_state.h"

#include <cmath>
#include <cstdint>
#include <vector>

namespace limber {

/// What a contact bore in a tick, in which its normal may turn.
struct TickImpulse {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();       ///< N s
  Eigen::Vector3d pressing = Eigen::Vector3d::Zero();  ///< N s, of it what was along the normals
  double along = 0.0;  ///< N s along them: 0 or more, since surfaces do not pull

  /// `impulse` has the part `size` along the unit normal.
  void add(const Eigen::Vector3d& impulse, const Eigen::Vector3d& normal, double size) {
    sum += impulse;
    pressing += size * normal;
    along += size;
  }
  TickImpulse& operator+=(const TickImpulse& other) {
    sum += other.sum;
    pressing += other.pressing;
    along += other.along;
    return *this;
  }
};

/// A point mass above a surface that nothing moves (static), or that moves as told (kinematic): the point's
/// centre must stay on the outer side of a plane, and slides on it with Coulomb friction.
///
///     gap(t) = normal . (x(t) - touch - t surfaceVelocity) >= 0,    t from the start of the tick
///
/// Where the surface is not flat around the point, the plane follows it from substep to substep.
struct PlaneContact {
  std::uint32_t point = 0;
  Eigen::Vector3d normal = Eigen::Vector3d::UnitY();  ///< unit, from the surface to the point
  Eigen::Vector3d touch = Eigen::Vector3d::Zero();    ///< m, where the centre touches at the tick's start
  Eigen::Vector3d surfaceVelocity = Eigen::Vector3d::Zero();  ///< m/s, constant over the tick
  double friction = 0.0;
  double restitution = 0.0;
  double bounceThreshold = 0.0;     ///< m/s, slower approaches do not bounce, or nothing would come to rest
  double recoverySpeed = HUGE_VAL;  ///< m/s, at which a point that is below the surface is lifted at most
  bool coupled = false;             ///< it is solved elsewhere, with contacts between bodies (contacts.h)

  HeldNeighbourhood* around = nullptr;  ///< what the plane follows, of a surface at rest; nullptr: it stays
  std::uint32_t owner = 0;              ///< its pieces in there
  bool away = false;                    ///< the point can touch none of these next

  // Written by the step.
  double mass = 0.0;                                  ///< kg along the normal; 0: cannot be moved
  TickImpulse impulse;                                ///< on the point
  bool touching = false;                              ///< it bore something in the present substep
  double target = 0.0;                                ///< m/s along the normal at least, in this substep
  bool bounces = false;                               ///< in this substep
  double rebound = 0.0;                               ///< m/s, see Bounce
  Eigen::Vector3d settled = Eigen::Vector3d::Zero();  ///< m/s of the point, when the last substep ended
};

/// The indices of a point's rows, among rows in the order of their points.
struct ContactRange {
  std::size_t begin, end;
};
ContactRange contactsOfPoint(const std::vector<PlaneContact>& rows, std::uint32_t point);

/// A substep in which a point meets a surface and parts from it by Newton's law of restitution: along its
/// normal `mean` is the speed of the drift, and `rebound` is added after the second kick.
///
/// The point meets the surface where and when it would under a constant force, and goes on from there. With
/// the drift's own speed, which is that of another time, what is pressed on would gain energy now and lose it
/// then, and on the whole gain.
struct Bounce {
  bool rests = true;  ///< it is slow, or would bounce on and on within the substep: it does not bounce
  double mean = 0.0, rebound = 0.0;
};

/// `approach` is its speed after the first kick, `before` that at the start of the substep.
Bounce bounceOf(double gap, double approach, double before, double restitution, double slow, double dt);

/// Share of a penetration taken back per substep, up to recoverySpeed: a body that was placed inside
/// something must come out, not be thrown out.
constexpr double kRecovery = 0.2;

/// Makes the planes of the rows of one point, those from `rows` on, those of the surface where it is, or
/// where it will meet it on its way (m). Looks for surfaces up to `within` (m) beyond that.
void followSurface(PlaneContact* rows, std::size_t count, const PointView& points,
                   const Eigen::Vector3d& displacement, double within);

/// Before a substep of dt: the same for all points.
void followSurfaces(std::vector<PlaneContact>& rows, const PointView& points, double dt);

/// Before the first substep of a tick: the rows' masses.
void prepareContacts(std::vector<PlaneContact>& rows, const PointView& points);

/// Before a drift of `dt` from `time` (s since the start of the tick): takes from each point the velocity
/// with which it would end below a surface, and as much of its sliding as friction allows. A point that is
/// already below is lifted gently. Rows of one point alternate until they agree; rows of different points are
/// independent, so this is exact.
void solvePositions(std::vector<PlaneContact>& rows, const PointView& points, double time, double dt);

/// Told of each drift before solvePositions(): finds contacts that nobody foresaw at the start of the tick.
struct ContactWatch {
  bool on = false;
  std::vector<PlaneContact> rows;  ///< found in this tick
  virtual ~ContactWatch() = default;
  virtual void look(const PointView& points, double time, double dt) = 0;
  /// Moves the rows to those of the body.
  virtual void merge() = 0;
};

/// After the second kick of a substep: a point that touches does not approach. This is to solvePositions what
/// RATTLE is to SHAKE: velocities are those of bodies at rest, not of a step in free fall.
void solveVelocities(std::vector<PlaneContact>& rows, const PointView& points);

}  // namespace limber
