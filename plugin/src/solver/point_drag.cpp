// SPDX-License-Identifier: Zlib
// Applies the drag of a medium to points.
#include "solver/point_drag.h"

#include <algorithm>
#include <cmath>
#include <type_traits>

namespace limber {
namespace {

/// J, of the points that are not held.
double kineticEnergyOf(const PointView& points, Eigen::Index count) {
  double sum = 0.0;
  for (std::uint32_t i = 0; i < count; ++i) {
    const Eigen::Vector3d v = points.velocityOf(i), w = points.inverseMassOf(i);
    for (int c = 0; c < 3; ++c) sum += w[c] > 0.0 ? 0.5 * v[c] * v[c] / w[c] : 0.0;
  }
  return sum;
}

void applyRate(double keep, const PointView& points, Eigen::Index count) {
  double* v = points.velocity;
  const double* w = points.inverseMass;
  for (Eigen::Index i = 0; i < count; ++i, v += points.pointStride, w += points.pointStride)
    for (int c = 0, at = 0; c < 3; ++c, at += points.axisStride) v[at] *= w[at] > 0.0 ? keep : 1.0;
}

/// Applies the decay, too. `axis`: the axis stride, a constant for bodies in arrays of their own.
template <class Axis>
void applyTerms(const PointDrag& drag, double keep, const PointView& points, Eigen::Index count, double dt,
                Axis axis) {
  const double* t = drag.terms.data();
  double* v = points.velocity;
  const double* w = points.inverseMass;
  for (Eigen::Index i = 0; i < count; ++i) {
    const double s = std::min(dt, t[9]), wx = w[0], wy = w[axis], wz = w[2 * axis];
    const double x = v[0] * (wx > 0.0 ? keep : 1.0), y = v[axis] * (wy > 0.0 ? keep : 1.0),
                 z = v[2 * axis] * (wz > 0.0 ? keep : 1.0);
    v[0] = x + s * wx * (t[6] - (t[0] * x + t[3] * y + t[5] * z));
    v[axis] = y + s * wy * (t[7] - (t[3] * x + t[1] * y + t[4] * z));
    v[2 * axis] = z + s * wz * (t[8] - (t[5] * x + t[4] * y + t[2] * z));
    t += PointDrag::kTerms, v += points.pointStride, w += points.pointStride;
  }
}

}  // namespace

void clearDrag(PointDrag& drag, Eigen::Index points) { drag.terms.setZero(PointDrag::kTerms, points); }

void addDrag(PointDrag& drag, Eigen::Index i, double k, const Eigen::Vector3d& n, double c,
             const Eigen::Vector3d& w) {
  double* t = drag.terms.data() + PointDrag::kTerms * i;
  const double along = k * n.dot(w);
  for (int axis = 0; axis < 3; ++axis) {
    t[axis] += k * n[axis] * n[axis] + c;
    t[6 + axis] += along * n[axis] + c * w[axis];
  }
  t[3] += k * n[0] * n[1];
  t[4] += k * n[1] * n[2];
  t[5] += k * n[2] * n[0];
}

void limitDrag(PointDrag& drag, const Points& inverseMass) {
  for (Eigen::Index i = 0; i < drag.terms.cols(); ++i) {
    auto t = drag.terms.col(i);
    // the largest row sum bounds the eigenvalues
    const double xy = std::abs(t[3]), yz = std::abs(t[4]), zx = std::abs(t[5]);
    const double largest = std::max({t[0] + xy + zx, t[1] + xy + yz, t[2] + yz + zx});
    const double rate = largest * inverseMass.col(i).maxCoeff();
    t[9] = rate > 0.0 ? 1.0 / rate : 0.0;
  }
}

void applyDrag(PointDrag& drag, const PointView& points, Eigen::Index count, double dt) {
  if (drag.measured) drag.work -= kineticEnergyOf(points, count);
  const double keep = drag.rate > 0.0 ? std::exp(-drag.rate * dt) : 1.0;
  if (drag.terms.cols() == 0)
    applyRate(keep, points, count);
  else if (points.axisStride == 1)
    applyTerms(drag, keep, points, count, dt, std::integral_constant<int, 1>());
  else
    applyTerms(drag, keep, points, count, dt, points.axisStride);
  if (drag.measured) drag.work += kineticEnergyOf(points, count);
}

}  // namespace limber
