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

/// Held coordinates get a unit row and no force.
void hold(const SpringSystem& system, SpringDerivatives& d) {
  const auto free = system.free.reshaped();
  for (Eigen::Index i = 0; i < free.size(); ++i) {
    if (free[i] != 0.0) continue;
    d.gradient[i] = 0.0;
    d.hessian.row(i).setZero();
    d.hessian.col(i).setZero();
    d.hessian(i, i) = 1.0;
  }
}

/// Newton's step where the matrix, made a little stiffer, is positive definite and the energy does fall.
bool improve(const SpringSystem& system, SpringDerivatives& d, double& stiffening, Eigen::Matrix3Xd& x) {
  const double before = energy(system, x);
  for (int attempt = 0; attempt < 60; ++attempt, stiffening *= 4.0) {
    Eigen::MatrixXd matrix = d.hessian;
    matrix.diagonal().array() += stiffening;
    const Eigen::LLT<Eigen::MatrixXd> factor(matrix);
    if (factor.info() != Eigen::Success) continue;
    const Eigen::VectorXd step = -factor.solve(d.gradient);
    const Eigen::Matrix3Xd moved = x + step.reshaped(3, x.cols());
    // a gain smaller than the rounding of the sum is a gain
    if (energy(system, moved) > before + 1e-14 * std::abs(before)) continue;
    x = moved;
    stiffening = std::max(stiffening / 16.0, 1e-12 * system.start.stiffnesses.maxCoeff());
    return true;
  }
  return false;
}

}  // namespace

Eigen::Matrix3Xd equilibrium(const SpringSystem& system) {
  Eigen::Matrix3Xd x = system.start.positions;
  double stiffening = 1e-3 * system.start.stiffnesses.maxCoeff();
  // springs know their lengths to rounding, and so their forces
  const double rounding = 1e-14 * system.start.stiffnesses.maxCoeff() * x.norm();
  const double enough = 1e-9 * system.load.norm() + rounding;
  for (int i = 0; i < 500; ++i) {
    SpringDerivatives d = springDerivatives(system.springs, system.start, x);
    d.gradient -= system.load.reshaped();
    hold(system, d);
    if (d.gradient.norm() <= enough) return x;
    if (!improve(system, d, stiffening, x)) break;
  }
  throw std::runtime_error("accuracy: no equilibrium found");
}

}  // namespace limber::bench
