// SPDX-License-Identifier: Zlib
// Applies the drag of a medium to points.
#include "solver/point_drag.h"

#include <algorithm>
#include <cmath>

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

void applyRate(double rate, const PointView& points, Eigen::Index count, double dt) {
  const double keep = std::exp(-rate * dt);
  for (std::uint32_t i = 0; i < count; ++i) {
    auto v = points.velocityOf(i);
    const Eigen::Vector3d w = points.inverseMassOf(i);
    for (int c = 0; c < 3; ++c) v[c] *= w[c] > 0.0 ? keep : 1.0;
  }
}

void applyTerms(const PointDrag& drag, const PointView& points, Eigen::Index count, double dt) {
  const double* t = drag.terms.data();
  for (std::uint32_t i = 0; i < count; ++i, t += PointDrag::kTerms) {
    auto v = points.velocityOf(i);
    const auto w = points.inverseMassOf(i);
    const double s = std::min(dt, t[9]), x = v[0], y = v[1], z = v[2];
    v[0] = x + s * w[0] * (t[6] - (t[0] * x + t[3] * y + t[5] * z));
    v[1] = y + s * w[1] * (t[7] - (t[3] * x + t[1] * y + t[4] * z));
    v[2] = z + s * w[2] * (t[8] - (t[5] * x + t[4] * y + t[2] * z));
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
  if (drag.rate > 0.0) applyRate(drag.rate, points, count, dt);
  if (drag.terms.cols() > 0) applyTerms(drag, points, count, dt);
  if (drag.measured) drag.work += kineticEnergyOf(points, count);
}

}  // namespace limber
