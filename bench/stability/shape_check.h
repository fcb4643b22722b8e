// SPDX-License-Identifier: Zlib
#pragma once

#include "engines/body_start.h"

namespace limber::bench {

/// What has become of a body's shape.
enum class Shape : std::uint8_t {
  Rest,      ///< its own, moved and turned anyhow
  Mirrored,  ///< its mirror image: the springs cannot tell the difference
  Other,     ///< another one in which its springs hold each other in a stable balance
  Saddle,    ///< one in an unstable balance: the exact motion can stay there only if it starts there
  Spinning,  ///< it turns so fast that the springs must be longer
  Lost       ///< none of these
};

const char* nameOf(Shape shape);

struct ShapeCheck {
  Shape shape = Shape::Lost;
  double error = 0.0;  ///< largest change of the distance of two points, as a share of `size`
};

constexpr double kShapeTolerance = 1e-3;

/// What checkShape looks at.
struct ShapeQuestion {
  const BodySetup& setup;
  const BodyStart& start;
  const Eigen::Matrix3Xd &positions, &velocities;
  double size;  ///< m
  bool alone;   ///< no forces but those of its own springs act
};

/// Compares all distances between two points with those of the rest shape; of what is not in its shape, what
/// holds it in another.
ShapeCheck checkShape(const ShapeQuestion& question);

/// kg m^2/s about the mass centre, and the sum of m |r| |v| relative to the centre.
struct Spin {
  Eigen::Vector3d momentum = Eigen::Vector3d::Zero();
  double scale = 0.0;
};
Spin spinOf(const Eigen::VectorXd& masses, const Eigen::Matrix3Xd& x, const Eigen::Matrix3Xd& v);

}  // namespace limber::bench
