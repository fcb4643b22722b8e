// SPDX-License-Identifier: Zlib
#pragma once

// How fast two surfaces move past each other. What turns together, as a tyre and its rim, does not.

#include "solver/point_state.h"

#include <Eigen/Core>

namespace limber {

/// The velocity of a surface:  mean + turn x (x - centre)  at x, up to `deformation`.
struct SurfaceMotion {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();  ///< m
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();    ///< m/s
  Eigen::Vector3d turn = Eigen::Vector3d::Zero();    ///< rad/s
  double radius = 0.0;                               ///< m, largest distance of a point from the centre
  double spread = 0.0;                               ///< m/s, largest departure of a point from the mean
  double deformation = 0.0;                          ///< m/s, largest departure from the mean and the turn

  bool isZero() const { return mean.isZero(0.0) && spread == 0.0; }
};

/// The positions or velocities of points, also in a PointView.
using PointColumns = Eigen::Ref<const Points, 0, Eigen::Stride<Eigen::Dynamic, Eigen::Dynamic>>;

/// Returns the motion of points with these velocities (m/s; for displacements in m the result is in m and
/// rad). The turn is that of least squares: with r = x - centre, the sum over the points of
/// |v - mean - turn x r|^2  is least for  I turn = sum r x v,  where  I = sum (|r|^2 1 - r r^T).
SurfaceMotion fittedMotion(const PointColumns& positions, const PointColumns& velocities);
SurfaceMotion fittedMotion(const PointView& points, Eigen::Index count);

/// The frame in which the motion of a surface relative to another is told: one that does not turn, or the one
/// of surface b, at the centre of a or b.
enum class MotionFrame { Still, AtA, AtB };

/// The velocity of surface a relative to surface b, where they may touch.
struct RelativeMotion {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();  ///< m/s, at the centre of the frame
  double spread = 0.0;                             ///< m/s, largest departure from it
  double turn = 0.0;                               ///< rad/s, at which the frame turns

  /// Returns the largest relative speed (m/s) of features of this size (m). The frame's turn moves the ends
  /// of a feature by half its size per rad, and turns the normals of contacts.
  double speed(double featureSize) const { return mean.norm() + spread + 0.5 * featureSize * turn; }
};

/// Returns the relative motion. With the fields of SurfaceMotion, the relative velocity at x is
///     mean_a - mean_b - turn_b x (c - centre_b) + (turn_a - turn_b) x (x - c)   for c = centre_a,
/// up to both deformations. A point of contact is within the radius of c. Likewise for c = centre_b.
RelativeMotion relativeMotion(const SurfaceMotion& a, const SurfaceMotion& b, MotionFrame frame);

/// Returns the frame in which the relative speed of features of this size (m) is least.
MotionFrame calmestFrame(const SurfaceMotion& a, const SurfaceMotion& b, double featureSize);

}  // namespace limber
