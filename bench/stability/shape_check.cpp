// SPDX-License-Identifier: Zlib
#include "stability/shape_check.h"

#include "stability/case_parts.h"

#include <Eigen/Dense>

#include <algorithm>

namespace limber::bench {
namespace {

/// Of k times the size: the largest force on a point that still counts as a balance.
constexpr double kBalance = 1e-3;
/// Of k: a curvature further below 0 than this is no rounding.
constexpr double kFlat = 1e-3;

double largestChange(const Eigen::Matrix3Xd& x, const Eigen::Matrix3Xd& rest) {
  double largest = 0.0;
  for (Eigen::Index i = 0; i < x.cols(); ++i)
    for (Eigen::Index j = i + 1; j < x.cols(); ++j)
      largest =
          std::max(largest, std::abs((x.col(i) - x.col(j)).norm() - (rest.col(i) - rest.col(j)).norm()));
  return largest;
}

/// Volume, with its sign, of the edges at the cube's first corner.
double handedness(const Eigen::Matrix3Xd& x) {
  const Eigen::Vector3d a = x.col(1) - x.col(0), b = x.col(2) - x.col(0), c = x.col(4) - x.col(0);
  return a.dot(b.cross(c));
}

/// Forces on the points (with the opposite sign) and the matrix of their changes.
struct Balance {
  Eigen::VectorXd gradient;
  Eigen::MatrixXd hessian;
};

/// A spring of k, length l, direction n and rest length L has, between its ends,
///   gradient k (l - L) n   and   Hessian k (n n^T + (1 - L / l) (1 - n n^T)).
Balance balanceOf(const BodySetup& setup, const BodyStart& start, const Eigen::Matrix3Xd& x) {
  Balance sum{Eigen::VectorXd::Zero(x.size()), Eigen::MatrixXd::Zero(x.size(), x.size())};
  const auto& springs = setup.network->springs;
  for (std::size_t s = 0; s < springs.size(); ++s) {
    const Eigen::Index i = static_cast<Eigen::Index>(s), a = 3 * springs[s].a, b = 3 * springs[s].b;
    const Eigen::Vector3d d = x.col(springs[s].b) - x.col(springs[s].a);
    const double length = d.norm(), k = start.stiffnesses[i], restLength = start.restLengths[i];
    if (length < 1e-9) continue;  // no direction, no force
    const Eigen::Vector3d n = d / length;
    const Eigen::Matrix3d along = n * n.transpose();
    const Eigen::Matrix3d block =
        k * (along + (1.0 - restLength / length) * (Eigen::Matrix3d::Identity() - along));
    sum.gradient.segment<3>(b) += k * (length - restLength) * n;
    sum.gradient.segment<3>(a) -= k * (length - restLength) * n;
    sum.hessian.block<3, 3>(a, a) += block;
    sum.hessian.block<3, 3>(b, b) += block;
    sum.hessian.block<3, 3>(a, b) -= block;
    sum.hessian.block<3, 3>(b, a) -= block;
  }
  return sum;
}

Shape otherShape(const BodySetup& setup, const BodyStart& start, const Eigen::Matrix3Xd& x, double size) {
  const Balance balance = balanceOf(setup, start, x);
  const double k = start.stiffnesses.maxCoeff();
  if (balance.gradient.cwiseAbs().maxCoeff() > kBalance * k * size) return Shape::Lost;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> modes(balance.hessian, Eigen::EigenvaluesOnly);
  return modes.eigenvalues()[0] < -kFlat * k ? Shape::Saddle : Shape::Other;
}

}  // namespace

const char* nameOf(Shape shape) {
  const char* const names[] = {"yes", "mirrored", "other balance", "saddle", "no"};
  return names[static_cast<int>(shape)];
}

ShapeCheck checkShape(const BodySetup& setup, const BodyStart& start, const Eigen::Matrix3Xd& positions,
                      double size, bool alone) {
  const Eigen::Matrix3Xd rest = restPositions(setup);
  ShapeCheck check;
  check.error = largestChange(positions, rest) / size;
  if (check.error <= kShapeTolerance)
    check.shape = handedness(positions) * handedness(rest) > 0.0 ? Shape::Rest : Shape::Mirrored;
  else if (alone)
    check.shape = otherShape(setup, start, positions, size);
  return check;
}

}  // namespace limber::bench
