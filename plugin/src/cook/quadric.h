// SPDX-License-Identifier: Zlib
#pragma once

#include "solver/linear_algebra.h"

namespace limber {

/// Weighted sum of squared distances from planes and points,  x^T a x - 2 b^T x + c  (M. Garland, P.
/// Heckbert, "Surface simplification using quadric error metrics", 1997).
struct Quadric {
  Eigen::Matrix3d a = Eigen::Matrix3d::Zero();
  Eigen::Vector3d b = Eigen::Vector3d::Zero();
  double c = 0.0;

  Quadric& operator+=(const Quadric& other) {
    a += other.a;
    b += other.b;
    c += other.c;
    return *this;
  }
  double at(const Eigen::Vector3d& x) const { return x.dot(a * x) - 2.0 * b.dot(x) + c; }

  /// Where it is least; some point must be in it, for planes alone may leave a line or more.
  Eigen::Vector3d minimum() const {
    Eigen::Vector3d x = b;
    solveSmall(a, x);
    return x;
  }
};

inline Quadric planeQuadric(const Eigen::Vector3d& unitNormal, const Eigen::Vector3d& through,
                            double weight) {
  const double offset = unitNormal.dot(through);
  return {weight * unitNormal * unitNormal.transpose(), weight * offset * unitNormal,
          weight * offset * offset};
}

inline Quadric pointQuadric(const Eigen::Vector3d& point, double weight) {
  return {weight * Eigen::Matrix3d::Identity(), weight * point, weight * point.squaredNorm()};
}

}  // namespace limber
