// SPDX-License-Identifier: Zlib
#include "scene/reference.h"

#include <Eigen/Cholesky>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace limber::bench {

// --- springs ---
namespace {

/// Computes the forces of springs, dampers and load.
void addForces(const SpringSystem& system, const State& state, Eigen::Matrix3Xd& force) {
  force = system.load;
  const BodyStart& s = system.start;
  for (std::size_t i = 0; i < system.springs.size(); ++i) {
    const auto [a, b] = std::pair(system.springs[i].a, system.springs[i].b);
    const auto n = static_cast<Eigen::Index>(i);
    const Eigen::Vector3d d = state.x.col(b) - state.x.col(a);
    const double length = d.norm();
    const Eigen::Vector3d u = d / length;
    const double stretchRate = u.dot(state.v.col(b) - state.v.col(a));
    const Eigen::Vector3d f =
        (s.stiffnesses[n] * (length - s.restLengths[n]) + s.dampings[n] * stretchRate) * u;
    force.col(a) += f;
    force.col(b) -= f;
  }
}

/// Returns 1 / m for free coordinates, else 0.
Eigen::Matrix3Xd inverseMasses(const SpringSystem& system) {
  return system.free.array().rowwise() / system.start.masses.transpose().array();
}

/// Sets the masses and weights with Bullet's rounding: a body stores 1 / m and computes its weight from it.
/// The effects of this rounding are not errors of a scheme.
void setRoundedWeights(const Eigen::Vector3d& gravity, SpringSystem& system) {
  system.load.resize(3, system.start.masses.size());
  for (Eigen::Index i = 0; i < system.start.masses.size(); ++i) {
    const btScalar inverse = btScalar(1) / static_cast<btScalar>(system.start.masses[i]);
    system.start.masses[i] = 1.0 / double(inverse);
    system.load.col(i) = fromBullet(toBullet(gravity) * (btScalar(1) / inverse));
  }
}

/// Returns an upper bound of the fastest oscillation (rad/s; Gershgorin's bound of the springs' matrix).
double frequencyBound(const SpringSystem& system) {
  Eigen::VectorXd sums = Eigen::VectorXd::Zero(system.start.masses.size());
  for (std::size_t i = 0; i < system.springs.size(); ++i) {
    sums[system.springs[i].a] += system.start.stiffnesses[static_cast<Eigen::Index>(i)];
    sums[system.springs[i].b] += system.start.stiffnesses[static_cast<Eigen::Index>(i)];
  }
  const Eigen::VectorXd ratios = sums.cwiseQuotient(system.start.masses);
  double bound = 0.0;
  for (const NetworkSpring& spring : system.springs)
    bound = std::max(bound, ratios[spring.a] + ratios[spring.b]);
  return std::sqrt(bound);
}

}  // namespace

SpringSystem systemOf(const BodySetup& setup, const Eigen::Vector3d& gravity) {
  SpringSystem system;
  system.springs = setup.network->springs;
  system.start = startOf(setup);
  system.free.setOnes(3, system.start.positions.cols());
  for (const std::uint32_t pin : setup.pins) system.free.col(pin).setZero();
  setRoundedWeights(gravity, system);
  return system;
}

State integrate(const SpringSystem& system, double seconds, double stepsPerRadian) {
  const auto steps = static_cast<long>(std::ceil(seconds * frequencyBound(system) * stepsPerRadian));
  const double h = seconds / static_cast<double>(steps);
  const Eigen::Matrix3Xd weight = inverseMasses(system);
  Eigen::Matrix3Xd force, a1, a2, a3, a4;
  const auto acceleration = [&](const State& state) {
    addForces(system, state, force);
    return Eigen::Matrix3Xd(force.cwiseProduct(weight));
  };
  State s{system.start.positions, system.start.velocities.cwiseProduct(system.free)}, at;
  for (long i = 0; i < steps; ++i) {
    a1 = acceleration(s);
    const Eigen::Matrix3Xd v2 = s.v + h / 2 * a1;
    a2 = acceleration({s.x + h / 2 * s.v, v2});
    const Eigen::Matrix3Xd v3 = s.v + h / 2 * a2;
    a3 = acceleration({s.x + h / 2 * v2, v3});
    const Eigen::Matrix3Xd v4 = s.v + h * a3;
    a4 = acceleration({s.x + h * v3, v4});
    s.x += h / 6 * (s.v + 2 * v2 + 2 * v3 + v4);
    s.v += h / 6 * (a1 + 2 * a2 + 2 * a3 + a4);
  }
  return s;
}

void integrateAgainst(const SpringSystem& system, const Wall& wall, double seconds, double h,
                      const std::function<void(double, const State&)>& onStep) {
  const Eigen::Matrix3Xd weight = inverseMasses(system);
  State s{system.start.positions, system.start.velocities};
  Eigen::Matrix3Xd force;
  const auto steps = static_cast<long>(std::lround(seconds / h));
  for (long step = 1; step <= steps; ++step) {
    addForces(system, s, force);
    s.v += h * force.cwiseProduct(weight);
    for (Eigen::Index i = 0; i < s.x.cols(); ++i) {
      const double gap = wall.normal.dot(s.x.col(i)) - wall.offset;
      const double correction = -gap / h - wall.normal.dot(s.v.col(i));
      if (correction > 0) s.v.col(i) += correction * wall.normal;
    }
    s.x += h * s.v;
    onStep(static_cast<double>(step) * h, s);
  }
}

// A spring of k, length l, direction n and rest length L has, between its ends,
//   gradient  k (l - L) n   and   Hessian  k n n^T + k (1 - L / l) (1 - n n^T)
SpringDerivatives springDerivatives(const std::vector<NetworkSpring>& springs, const BodyStart& start,
                                    const Eigen::Matrix3Xd& x) {
  constexpr double kCoincident = 1e-9;  // m; the ends of a shorter spring coincide
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

// --- signals ---

namespace {

constexpr double kNever = std::numeric_limits<double>::infinity();
constexpr long kStencil = 6;

/// Returns the time between `low` and `high` at which the signal crosses the level, by bisection.
double crossingTime(const Signal& signal, double level, double low, double high) {
  const bool below = signal.at(low) < level;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    ((signal.at(middle) < level) == below ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

}  // namespace

double Signal::at(double t) const {
  const auto count = static_cast<long>(samples.size());
  const long points = std::min(kStencil, count);
  const long first = std::clamp(static_cast<long>(std::floor(t / dt)) - kStencil / 2 + 1, 0l, count - points);
  double sum = 0.0;
  for (long i = first; i < first + points; ++i) {
    double weight = 1.0;
    for (long j = first; j < first + points; ++j)
      if (j != i) weight *= (t / dt - static_cast<double>(j)) / static_cast<double>(i - j);
    sum += weight * samples[static_cast<std::size_t>(i)];
  }
  return sum;
}

std::vector<double> fallsThroughZero(const Signal& signal) {
  std::vector<double> falls;
  for (std::size_t i = 1; i < signal.samples.size(); ++i)
    if (signal.samples[i - 1] > 0 && signal.samples[i] <= 0)
      falls.push_back(crossingTime(signal, 0.0, signal.dt * static_cast<double>(i - 1),
                                   signal.dt * static_cast<double>(i)));
  return falls;
}

double period(const Signal& signal) {
  const std::vector<double> falls = fallsThroughZero(signal);
  if (falls.size() < 2) return kNever;
  return (falls.back() - falls.front()) / static_cast<double>(falls.size() - 1);
}

double amplitude(const Signal& signal, double from, double to) {
  double largest = 0.0;
  const double step = signal.dt / 32;
  for (double t = std::max(from, 0.0); t <= std::min(to, signal.end()); t += step)
    largest = std::max(largest, std::abs(signal.at(t)));
  return largest;
}

double firstReaches(const Signal& signal, double level, double from) {
  const auto first = static_cast<std::size_t>(std::ceil(from / signal.dt));
  for (std::size_t i = first + 1; i < signal.samples.size(); ++i)
    if ((signal.samples[i - 1] < level) != (signal.samples[i] < level))
      return crossingTime(signal, level, signal.dt * static_cast<double>(i - 1),
                          signal.dt * static_cast<double>(i));
  return kNever;
}

}  // namespace limber::bench
