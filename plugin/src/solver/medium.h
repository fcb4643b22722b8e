// SPDX-License-Identifier: Zlib
#pragma once

// The forces of air and water on the triangles and segments of a body, and the drag on its points, as the
// steppers apply it.

#include "solver/point_state.h"

#include <limber/mesh.h>

#include <array>
#include <cstdint>
#include <vector>

namespace limber {

// --- air and water -----------------------------------------------------------------------------------------

/// The parts of a body that a flow acts on. All lists but one are empty.
struct WettedParts {
  double volume = 0.0;                                 ///< m^3, of a closed body
  double modulus = 0.0;                                ///< Pa, its Young's modulus
  std::vector<Triangle> closed;                        ///< outward, of closed surfaces
  std::vector<Triangle> sheets;                        ///< of open ones
  std::vector<std::array<std::uint32_t, 2>> segments;  ///< of ropes

  bool empty() const { return closed.empty() && sheets.empty() && segments.empty(); }
};

/// A medium with the coefficients of a body in it.
struct Flow {
  double density = 0.0;           ///< kg/m^3
  double drag = 0.0, lift = 0.0;  ///< see FlowCoefficients
  double friction = 0.0;
  const Points* velocityAt = nullptr;                  ///< 3 x #points, m/s; nullptr: `velocity` everywhere
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();  ///< m/s

  bool acts() const { return density > 0.0 && drag + friction > 0.0; }
};

/// The plane of the water: points x with  up . x < level  are below.
struct WaterPlane {
  Eigen::Vector3d up = Eigen::Vector3d::Zero();  ///< unit vector against gravity; 0: no water
  double level = 0.0;                            ///< m
  double weight = 0.0;                           ///< N/m^3, of the water
  bool isThere() const { return weight > 0.0; }
  double depthOf(const Eigen::Vector3d& x) const { return level - up.dot(x); }
};

// --- the drag on points ------------------------------------------------------------------------------------

/// How the drag in air is computed again within a tick, for a body so light that it turns in the flow within
/// it. With the lift of where it was at the start of the tick, a flag would gain energy.
struct DragUpdates {
  double interval = 0.0;  ///< s between two; 0: there are none
  const WettedParts* parts = nullptr;
  double diameter = 0.0;  ///< m, see addDragOfParts()
  Flow air;
  const Points* inverseMass = nullptr;              ///< 3 x #points, 1/kg
  Points *position = nullptr, *velocity = nullptr;  ///< scratch
  double since = 0.0;                               ///< s, since the last one
};

/// The force  b - D v  on each point with the velocity v, with D and b constant over a tick or, with updates,
/// over a part of it, and the decay of velocities by exp(-rate t). After the second kick of a substep of dt
/// seconds the points get
///
///     v <- v + s W (b - D v),   s = min(dt, 1 / |W D|),
///
/// with the inverse masses W. Steady states are exact while  |W D| dt <= 1: a point that springs hold gets
/// the force b, a point in free fall ends at the velocity of balance. A larger drag is limited to what brings
/// the point to rest in the medium within a substep, so it never overshoots: s W D has eigenvalues from 0 to
/// 1, and the kinetic energy relative to the medium's velocity  D^-1 b  never rises.
struct PointDrag {
  static constexpr int kTerms = 10;
  using Terms = Eigen::Matrix<double, kTerms, Eigen::Dynamic>;

  /// #points, or no columns without a medium: D as xx yy zz xy yz zx (N s/m), b (N), 1 / |W D| (s).
  Terms terms;
  double rate = 0.0;      ///< 1/s
  bool measured = false;  ///< `work` and `impulse` are wanted
  double work = 0.0;      ///< J, change of the kinetic energy in this tick, if measured
  Eigen::Vector3d impulse = Eigen::Vector3d::Zero();  ///< N s, likewise of the momentum
  DragUpdates updates;
};

/// Sets D and b of all points to 0.
void clearDrag(PointDrag& drag, Eigen::Index points);

/// Adds  D = k n n^T + c 1  and  b = D w  to point i: n is a unit vector, w a velocity (m/s).
void addDrag(PointDrag& drag, Eigen::Index i, double k, const Eigen::Vector3d& n, double c,
             const Eigen::Vector3d& w);

/// Computes the limits after all addDrag(). Returns the largest |W D| of a point, 1/s.
double limitDrag(PointDrag& drag, const Points& inverseMass);

/// Starts the substeps of a tick, or the same ones again. `points`: at the start of the tick.
void startDrag(PointDrag& drag, const PointView& points, Eigen::Index count);

/// Applies the drag of a substep of dt seconds. Call it before the contacts are solved.
void applyDrag(PointDrag& drag, const PointView& points, Eigen::Index count, double dt);

// --- what air and water add ------------------------------------------------------------------------------

/// The points of a body in a flow.
struct MovingPoints {
  const Points& position;  ///< 3 x #points, m
  const Points& velocity;  ///< 3 x #points, m/s, for the speed of the flow past each part
};

/// Adds the drag in air, and in water below the plane, of all parts to the points' drag. `diameter` (m) is
/// that of the segments.
void addDragOfParts(const WettedParts& parts, double diameter, const MovingPoints& points, const Flow& air,
                    const Flow& water, const WaterPlane& plane, PointDrag& drag);

/// Adds the integral of the water's pressure over closed triangles below the plane to `force` (3 x #points,
/// N), exactly for plane triangles, so that it sums up to the weight of the displaced water. Returns the area
/// (m^2) of the water's plane inside the surface.
double addBuoyancy(const std::vector<Triangle>& closed, const Points& position, const WaterPlane& plane,
                   Points& force);

}  // namespace limber
