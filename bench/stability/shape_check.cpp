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

Shape balancedShape(const ShapeQuestion& q) {
  const Balance balance = balanceOf(q.setup, q.start, q.positions);
  const double k = q.start.stiffnesses.maxCoeff();
  if (balance.gradient.cwiseAbs().maxCoeff() > kBalance * k * q.size) return Shape::Lost;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> modes(balance.hessian, Eigen::EigenvaluesOnly);
  return modes.eigenvalues()[0] < -kFlat * k ? Shape::Saddle : Shape::Other;
}

/// The spring that carries m w^2 r of a point alone becomes longer by m w^2 r / k. Where that is beyond the
/// tolerance, w being the speed of a rigid body with the same angular momentum, the rest shape cannot be had.
bool spinsApart(const ShapeQuestion& q) {
  const Eigen::VectorXd& m = q.start.masses;
  const Eigen::Vector3d centre = q.positions * m / m.sum();
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();
  for (Eigen::Index i = 0; i < m.size(); ++i) {
    const Eigen::Vector3d r = q.positions.col(i) - centre;
    inertia += m[i] * (r.squaredNorm() * Eigen::Matrix3d::Identity() - r * r.transpose());
  }
  const Eigen::Vector3d spin = spinOf(m, q.positions, q.velocities).momentum;
  const double omega = inertia.completeOrthogonalDecomposition().solve(spin).norm();
  const double radius = (q.positions.colwise() - centre).colwise().norm().maxCoeff();
  return m.maxCoeff() * omega * omega * radius > kShapeTolerance * q.size * q.start.stiffnesses.maxCoeff();
}

}  // namespace

const char* nameOf(Shape shape) {
  const char* const names[] = {"yes", "mirrored", "other balance", "saddle", "spinning", "no"};
  return names[static_cast<int>(shape)];
}

Spin spinOf(const Eigen::VectorXd& masses, const Eigen::Matrix3Xd& x, const Eigen::Matrix3Xd& v) {
  const Eigen::Vector3d centre = x * masses / masses.sum(), flight = v * masses / masses.sum();
  Spin spin;
  for (Eigen::Index i = 0; i < masses.size(); ++i) {
    const Eigen::Vector3d r = x.col(i) - centre, u = v.col(i) - flight;
    spin.momentum += masses[i] * r.cross(u);
    spin.scale += masses[i] * r.norm() * u.norm();
  }
  return spin;
}

ShapeCheck checkShape(const ShapeQuestion& q) {
  const Eigen::Matrix3Xd rest = restPositions(q.setup);
  ShapeCheck check;
  check.error = largestChange(q.positions, rest) / q.size;
  if (check.error <= kShapeTolerance)
    check.shape = handedness(q.positions) * handedness(rest) > 0.0 ? Shape::Rest : Shape::Mirrored;
  else if (spinsApart(q))
    check.shape = Shape::Spinning;
  else if (q.alone)
    check.shape = balancedShape(q);
  return check;
}

}  // namespace limber::bench
