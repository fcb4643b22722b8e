// SPDX-License-Identifier: Zlib
#pragma once

#include <Eigen/Core>

namespace limber {

/// One column per point mass.
using Points = Eigen::Matrix3Xd;

/// The state of a body's point masses, in double so that it is not limited by the host's precision.
/// All arrays are 3 x #points.
struct PointState {
  Points position;      ///< m
  Points velocity;      ///< m/s
  Points acceleration;  ///< m/s^2 from everything but the springs, constant over a tick
  Points inverseMass;   ///< 1/kg per axis; 0 where a point is held
  Points force;         ///< N from the springs at `position`
  Points earlierForce;  ///< N, scratch of the step

  void resize(Eigen::Index points) {
    for (Points* array : {&position, &velocity, &acceleration, &inverseMass, &force, &earlierForce})
      array->setZero(3, points);
  }
};

}  // namespace limber
