// SPDX-License-Identifier: Zlib
#include "engines/spring_derivatives.h"

namespace limber::bench {
namespace {

/// m; the ends of a shorter spring coincide.
constexpr double kCoincident = 1e-9;

}  // namespace

// A spring of k, length l, direction n and rest length L has, between its ends,
//   gradient  k (l - L) n   and   Hessian  k n n^T + k (1 - L / l) (1 - n n^T)
SpringDerivatives springDerivatives(const std::vector<NetworkSpring>& springs, const BodyStart& start,
                                    const Eigen::Matrix3Xd& x) {
  SpringDerivatives d{Eigen::VectorXd::Zero(x.size()), Eigen::MatrixXd::Zero(x.size(), x.size())};
  for (std::size_t s = 0; s < springs.size(); ++s) {
    const auto i = static_cast<Eigen::Index>(s);
    const Eigen::Index a = 3 * Eigen::Index{springs[s].a}, b = 3 * Eigen::Index{springs[s].b};
    const Eigen::Vector3d along = x.col(b / 3) - x.col(a / 3);
    const double length = along.norm(), k = start.stiffnesses[i], rest = start.restLengths[i];
    if (length < kCoincident) continue;
    const Eigen::Vector3d n = along / length;
    const Eigen::Matrix3d nn = n * n.transpose();
    const Eigen::Matrix3d block = k * nn + k * (1.0 - rest / length) * (Eigen::Matrix3d::Identity() - nn);
    d.gradient.segment<3>(b) += k * (length - rest) * n;
    d.gradient.segment<3>(a) -= k * (length - rest) * n;
    d.hessian.block<3, 3>(a, a) += block;
    d.hessian.block<3, 3>(b, b) += block;
    d.hessian.block<3, 3>(a, b) -= block;
    d.hessian.block<3, 3>(b, a) -= block;
  }
  return d;
}

}  // namespace limber::bench
