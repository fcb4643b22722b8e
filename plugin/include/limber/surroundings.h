// SPDX-License-Identifier: Zlib
#pragma once

// What surrounds soft bodies: air, water and fields of force. SoftBodySystem::setAir(), setWater() and
// addField() set them; SoftBodySettings::flow has the coefficients of a body.

#include <limber/export.h>
#include <limber/result.h>

#include <Eigen/Core>

#include <cstddef>
#include <functional>
#include <optional>

namespace limber {

// --- the coefficients of a body ----------------------------------------------------------------------------

/// Coefficients of the forces of air and water on a body, and its own linear drag. A triangle of area A whose
/// plane makes the angle alpha with a flow of relative speed u and density rho has
///     drag = 1/2 rho u^2 A sin(alpha) (drag - lift (1 - sin(alpha))),   lift = 1/2 rho u^2 A lift sin cos,
/// so `drag` is that of a plate broadside to the flow, and a sphere's by its frontal area if `lift` is 0.
/// Each triangle of a closed surface counts half, since its windward and its leeward side have equal areas.
/// The segments of ropes are cylinders of the point radius, with the drag of the flow across them. Solids
/// whose surface is open, as by a cut, count as cloths here. (S. F. Hoerner, Fluid-Dynamic Drag, 1965.)
struct FlowCoefficients {
  std::optional<double> drag;  ///< 0 to 100; default: 1.2 for ropes and cloths; for solids 0 in air and 1 in
                               ///< water
  std::optional<double> lift;  ///< 0 to `drag`; default: `drag` for cloths, else 0. Ropes have none of their
                               ///< own, but a flow across a slanting rope lifts it
  double friction = 0.02;      ///< of the flow along the surface, 0 to 100; only where `drag` is not 0
  std::optional<double> linearDrag;  ///< 1/s, 0 to 1e6: velocities fall by exp(-linearDrag t), without any
                                     ///< medium. Default: 0.3 for ropes and cloths, which so come to rest
                                     ///< within seconds; 0 for solids, but 0.5 for their points under water,
                                     ///< as the waves that they make carry energy away
  double displacedVolume = 0.0;  ///< m^3, 0 to 1e9, of a body that encloses no volume (rope, cloth): water
                                 ///< lifts it by the weight of as much water
};

// --- air and water -----------------------------------------------------------------------------------------

/// Returns the velocity (m/s) of the air at a place (m) and time (s since the system was made). Called for
/// every point of an awake body with drag, where it will be in the middle of the tick, on any thread and on
/// several at a time with setParallelFor(). It must not throw, and gives equal results for equal arguments if
/// runs shall be equal. Results that are not finite count as 0, and others are limited to 1e6 m/s.
using WindFunction = std::function<Eigen::Vector3d(const Eigen::Vector3d& place, double time)>;

struct Air {
  double density = 1.2;                            ///< kg/m^3, 0 (none) to 1e9
  Eigen::Vector3d wind = Eigen::Vector3d::Zero();  ///< m/s, each component to 1e6
  WindFunction windAt;                             ///< if set, is added to `wind`
};

/// Water below a plane perpendicular to gravity. It carries the volume of closed surfaces below the plane,
/// rho g V exactly, and all bodies have drag in it. It does not get out of the way: no waves, no wake. A
/// solid of up to a tenth of the water's density has the inertia of the water that it pushes aside, too: half
/// the displaced mass, as a sphere; from a fifth on none. On a solid that is too light for the tick, the
/// water acts as a whole, with that inertia, and the waves carry its energy away (unless FlowCoefficients::
/// linearDrag is set), so that it comes to rest. The pressure, counted from the top of a body that is under
/// water, compresses soft bodies: they displace less. Depth alone compresses nothing, neither solids nor gas.
struct Water {
  double density = 1000.0;                         ///< kg/m^3, 1e-15 to 1e9
  double level = 0.0;                              ///< m, to 1e6, height of the plane against gravity
  Eigen::Vector3d flow = Eigen::Vector3d::Zero();  ///< m/s, velocity, each component to 1e6
};

/// Returns gusts for Air::windAt: frozen turbulence that the mean wind (m/s) carries along, at most
/// `strength` (m/s) fast and mostly along the mean wind, with eddies about `size` (m, above 0) across. It is
/// the same in every run.
LIMBER_API WindFunction gusts(const Eigen::Vector3d& meanWind, double strength, double size);

/// Checks settings. The error is the first invalid field and the reason.
LIMBER_API Result<void> validate(const Air& air);
LIMBER_API Result<void> validate(const Water& water);
LIMBER_API Result<void> validate(const FlowCoefficients& flow);

// --- fields ------------------------------------------------------------------------------------------------

/// The points of one body at the start of a tick. All arrays are flat: x y z of point 0, of point 1, ...
struct FieldPoints {
  std::size_t count;
  const double* positions;   ///< 3 x count, m, in the middle of the tick if no force acted in it
  const double* velocities;  ///< 3 x count, m/s
  const double* masses;      ///< count, kg; 0: a pinned point, which fields do not move
  double time;               ///< s since the system was made, in the middle of the tick
  double* accelerations;     ///< 3 x count, m/s^2, in and out: add to them. They act all through the tick
};

/// A field of force, called once a tick for each awake body that it acts on, in the order of the bodies, on
/// the thread that steps the world. It must not throw, nor call the system. Accelerations that depend on the
/// place alone gain no energy: those of the middle of the tick make leapfrog steps (drift, kick, drift),
/// which are stable up to w = 2 / tick for a spring of w rad/s. Drag that a field adds is explicit and
/// unstable above 2 / tick; FlowCoefficients has drag that is stable.
using ForceField = std::function<void(const FieldPoints& points)>;

}  // namespace limber
