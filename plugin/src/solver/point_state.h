// SPDX-License-Identifier: Zlib
#pragma once

#include <Eigen/Core>

namespace limber {

/// One column per point mass.
using Points = Eigen::Matrix3Xd;

inline double dot(const Points& a, const Points& b) { return a.cwiseProduct(b).sum(); }

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

/// Whether point i is held; one that may move along some axes only is not.
inline bool isHeld(const Points& inverseMass, Eigen::Index i) { return inverseMass.col(i).maxCoeff() == 0.0; }

/// kg; 0 for a point that is held.
inline double massOf(const Points& inverseMass, Eigen::Index i) {
  const double w = inverseMass.col(i).maxCoeff();
  return w > 0.0 ? 1.0 / w : 0.0;
}

}  // namespace limber
