// SPDX-License-Identifier: Zlib
#include "accuracy/spring_system.h"
#include "engines/spring_derivatives.h"

#include <Eigen/Cholesky>

#include <cmath>
#include <stdexcept>

namespace limber::bench {
namespace {

double energy(const SpringSystem& system, const Eigen::Matrix3Xd& x) {
  double sum = -system.load.cwiseProduct(x).sum();
  for (std::size_t i = 0; i < system.springs.size(); ++i) {
    const auto n = static_cast<Eigen::Index>(i);
    const double length = (x.col(system.springs[i].b) - x.col(system.springs[i].a)).norm();
    const double stretch = length - system.start.restLengths[n];
    sum += 0.5 * system.start.stiffnesses[n] * stretch * stretch;
  }
  return sum;
}

/// Replaces the equations of held coordinates by unit rows without force.
void fixHeldCoordinates(const SpringSystem& system, SpringDerivatives& d) {
  const auto free = system.free.reshaped();
  for (Eigen::Index i = 0; i < free.size(); ++i) {
    if (free[i] != 0.0) continue;
    d.gradient[i] = 0.0;
    d.hessian.row(i).setZero();
    d.hessian.col(i).setZero();
    d.hessian(i, i) = 1.0;
  }
}

/// Makes a Newton step. Stiffens the matrix until it is positive definite and the energy falls.
bool improve(const SpringSystem& system, SpringDerivatives& d, double& stiffening, Eigen::Matrix3Xd& x) {
  const double oldEnergy = energy(system, x);
  for (int attempt = 0; attempt < 60; ++attempt, stiffening *= 4.0) {
    Eigen::MatrixXd matrix = d.hessian;
    matrix.diagonal().array() += stiffening;
    const Eigen::LLT<Eigen::MatrixXd> factor(matrix);
    if (factor.info() != Eigen::Success) continue;
    const Eigen::VectorXd step = -factor.solve(d.gradient);
    const Eigen::Matrix3Xd next = x + step.reshaped(3, x.cols());
    // changes within the rounding of the sum are accepted
    if (energy(system, next) > oldEnergy + 1e-14 * std::abs(oldEnergy)) continue;
    x = next;
    stiffening = std::max(stiffening / 16.0, 1e-12 * system.start.stiffnesses.maxCoeff());
    return true;
  }
  return false;
}

}  // namespace

Eigen::Matrix3Xd equilibrium(const SpringSystem& system) {
  Eigen::Matrix3Xd x = system.start.positions;
  double stiffening = 1e-3 * system.start.stiffnesses.maxCoeff();
  // the forces have the rounding of the springs' lengths
  const double rounding = 1e-14 * system.start.stiffnesses.maxCoeff() * x.norm();
  const double tolerance = 1e-9 * system.load.norm() + rounding;
  for (int i = 0; i < 500; ++i) {
    SpringDerivatives d = springDerivatives(system.springs, system.start, x);
    d.gradient -= system.load.reshaped();
    fixHeldCoordinates(system, d);
    if (d.gradient.norm() <= tolerance) return x;
    if (!improve(system, d, stiffening, x)) break;
  }
  throw std::runtime_error("accuracy: no equilibrium found");
}

}  // namespace limber::bench
