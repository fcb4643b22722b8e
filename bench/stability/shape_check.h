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
  Lost       ///< none of these
};

const char* nameOf(Shape shape);

struct ShapeCheck {
  Shape shape = Shape::Lost;
  double error = 0.0;  ///< largest change of the distance of two points, as a share of `size`
};

constexpr double kShapeTolerance = 1e-3;

/// Compares all distances between two points with those of the rest shape. Of what is not at rest in its
/// shape, `alone` looks at the springs' forces: no other forces act then.
ShapeCheck checkShape(const BodySetup& setup, const BodyStart& start, const Eigen::Matrix3Xd& positions,
                      double size, bool alone);

}  // namespace limber::bench
