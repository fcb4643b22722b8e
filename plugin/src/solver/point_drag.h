// SPDX-License-Identifier: Zlib
#pragma once

// The drag of a medium on the points of a body, as the steppers apply it.

#include "solver/point_state.h"

namespace limber {

/// The force  b - D v  on each point with the velocity v, with D and b constant over a tick, and the decay of
/// velocities by exp(-rate t). After the second kick of a substep of dt seconds the points get
///
///     v <- v + s W (b - D v),   s = min(dt, 1 / |W D|),
///
/// with the inverse masses W. Steady states are exact while  |W D| dt <= 1: a point that springs hold gets
/// the force b, a point in free fall ends at the velocity of balance. A larger drag is limited to what brings
/// the point to rest in the medium within a substep, so it never overshoots: s W D has eigenvalues from 0 to
/// 1, and the kinetic energy relative to the medium's velocity  D^-1 b  never rises.
struct PointDrag {
  static constexpr int kTerms = 10;
  /// #points, or no columns without a medium: D as xx yy zz xy yz zx (N s/m), b (N), 1 / |W D| (s).
  Eigen::Matrix<double, kTerms, Eigen::Dynamic> terms;
  double rate = 0.0;      ///< 1/s
  bool measured = false;  ///< `work` is wanted
  double work = 0.0;      ///< J, change of the kinetic energy in this tick, if measured
};

/// Sets D and b of all points to 0.
void clearDrag(PointDrag& drag, Eigen::Index points);

/// Adds  D = k n n^T + c 1  and  b = D w  to point i: n is a unit vector, w a velocity (m/s).
void addDrag(PointDrag& drag, Eigen::Index i, double k, const Eigen::Vector3d& n, double c,
             const Eigen::Vector3d& w);

/// Computes the limits after all addDrag().
void limitDrag(PointDrag& drag, const Points& inverseMass);

/// Applies the drag of a substep of dt seconds. Call it before the contacts are solved.
void applyDrag(PointDrag& drag, const PointView& points, Eigen::Index count, double dt);

}  // namespace limber
