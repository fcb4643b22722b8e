// SPDX-License-Identifier: Zlib
#pragma once

#include "bullet_soft/body_start.h"

namespace limber::bench {

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
