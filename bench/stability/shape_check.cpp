// SPDX-License-Identifier: Zlib
#include "stability/shape_check.h"

#include "engines/spring_derivatives.h"
#include "mesh/linear_algebra.h"
#include "stability/case_parts.h"

#include <Eigen/Geometry>

#include <algorithm>

namespace limber::bench {
namespace {

/// Fraction of k times the size: the largest force on a point in equilibrium.
constexpr double kMaxBalanceForce = 1e-3;
/// Fraction of k: a curvature below minus this value is not a rounding error.
constexpr double kMinCurvature = 1e-3;

double largestChange(const Eigen::Matrix3Xd& x, const Eigen::Matrix3Xd& rest) {
  double largest = 0.0;
  for (Eigen::Index i = 0; i < x.cols(); ++i)
    for (Eigen::Index j = i + 1; j < x.cols(); ++j)
      largest =
          std::max(largest, std::abs((x.col(i) - x.col(j)).norm() - (rest.col(i) - rest.col(j)).norm()));
  return largest;
}

/// Returns the signed volume of the edges at the cube's first corner.
double handedness(const Eigen::Matrix3Xd& x) {
  const Eigen::Vector3d a = x.col(1) - x.col(0), b = x.col(2) - x.col(0), c = x.col(4) - x.col(0);
  return a.dot(b.cross(c));
}

Shape balancedShape(const ShapeQuestion& q) {
  const SpringDerivatives energy = springDerivatives(q.setup.network->springs, q.start, q.positions);
  const double k = q.start.stiffnesses.maxCoeff();
  if (energy.gradient.cwiseAbs().maxCoeff() > kMaxBalanceForce * k * q.size) return Shape::Lost;
  return limber::symmetricValues(energy.hessian)[0] < -kMinCurvature * k ? Shape::Saddle : Shape::Other;
}

/// Returns whether the rotation prevents the rest shape. A spring that provides the force m w^2 r for a point
/// alone is longer by m w^2 r / k. The rest shape is impossible if this exceeds the tolerance, where w is the
/// angular speed of a rigid body with the same angular momentum.
bool spinsTooFast(const ShapeQuestion& q) {
  const Eigen::VectorXd& m = q.start.masses;
  const Eigen::Vector3d centre = q.positions * m / m.sum();
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();
  for (Eigen::Index i = 0; i < m.size(); ++i) {
    const Eigen::Vector3d r = q.positions.col(i) - centre;
    inertia += m[i] * (r.squaredNorm() * Eigen::Matrix3d::Identity() - r * r.transpose());
  }
  const Eigen::Vector3d spin = spinOf(m, q.positions, q.velocities).momentum;
  const double omega = (limber::pseudoInverse(inertia) * spin).norm();
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
  else if (spinsTooFast(q))
    check.shape = Shape::Spinning;
  else if (q.alone)
    check.shape = balancedShape(q);
  return check;
}

}  // namespace limber::bench
