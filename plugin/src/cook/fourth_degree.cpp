// SPDX-License-Identifier: Zlib
#include "cook/fourth_degree.h"

#include <cmath>

namespace limber {
namespace {

/// The roots of how often the entries occur: 1, 4, 6 and 12 times.
FourthDegree rootsOfCounts() {
  FourthDegree roots;
  roots.head<3>().setOnes();
  roots.segment<6>(3).setConstant(2.0);
  roots.segment<3>(9).setConstant(std::sqrt(6.0));
  roots.tail<3>().setConstant(std::sqrt(12.0));
  return roots;
}

FourthDegree weighted(const FourthDegree& entries) {
  static const FourthDegree roots = rootsOfCounts();
  return entries.cwiseProduct(roots);
}

}  // namespace

FourthDegree fourthPower(const Eigen::Vector3d& n) {
  const double x = n[0], y = n[1], z = n[2], xx = x * x, yy = y * y, zz = z * z;
  FourthDegree t;
  t << xx * xx, yy * yy, zz * zz, xx * x * y, xx * x * z, yy * y * x, yy * y * z, zz * z * x, zz * z * y,
      xx * yy, yy * zz, zz * xx, xx * y * z, yy * z * x, zz * x * y;
  return weighted(t);
}

FourthDegree isotropicElasticity() {
  FourthDegree t = FourthDegree::Zero();
  t.head<3>().setConstant(1.2);
  t.segment<3>(9).setConstant(0.4);
  return weighted(t);
}

FourthDegree symmetricPart(const Eigen::Matrix<double, 6, 6>& c) {
  const auto mean = [](double once, double twice) { return (once + 2.0 * twice) / 3.0; };
  FourthDegree t;
  t << c(0, 0), c(1, 1), c(2, 2), c(0, 5), c(0, 4), c(1, 5), c(1, 3), c(2, 4), c(2, 3),
      mean(c(0, 1), c(5, 5)), mean(c(1, 2), c(3, 3)), mean(c(2, 0), c(4, 4)), mean(c(0, 3), c(4, 5)),
      mean(c(1, 4), c(3, 5)), mean(c(2, 5), c(3, 4));
  return weighted(t);
}

}  // namespace limber
