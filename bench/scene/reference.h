// SPDX-License-Identifier: Zlib
#pragma once

// What results are compared with: solutions of the same equations, and properties of signals.

#include "engines/engines.h"

namespace limber::bench {

// --- springs ---

/// The points and springs of a set-up as plain equations, in double precision, which every engine should
/// solve. It uses none of Limber's computations, so that a common error cannot stay hidden.
struct SpringSystem {
  std::vector<NetworkSpring> springs;
  BodyStart start;
  Eigen::Matrix3Xd free;  ///< 3 x #points, 1 where a coordinate may change, else 0
  Eigen::Matrix3Xd load;  ///< 3 x #points, N, gravity included
};

SpringSystem systemOf(const BodySetup& setup, const Eigen::Vector3d& gravity);

/// Derivatives of the springs' energy with respect to the points' positions, ordered x y z of each point.
struct SpringDerivatives {
  Eigen::VectorXd gradient;  ///< N, 3 #points
  Eigen::MatrixXd hessian;   ///< N/m, 3 #points square
};

/// Written independently of Limber's code, so that no error is common to both. Springs whose ends coincide
/// have no direction and are left out.
SpringDerivatives springDerivatives(const std::vector<NetworkSpring>& springs, const BodyStart& start,
                                    const Eigen::Matrix3Xd& x);

struct State {
  Eigen::Matrix3Xd x, v;
};

/// Returns the state after `seconds`, by the classical Runge-Kutta method of order 4 with `stepsPerRadian`
/// steps per radian of the fastest oscillation.
State integrate(const SpringSystem& system, double seconds, double stepsPerRadian = 20.0);

/// Returns the rest positions of the points: a minimum of the energy, by Newton's method with step-size
/// control from the start's positions. Throws std::runtime_error if it finds none.
Eigen::Matrix3Xd equilibrium(const SpringSystem& system);

/// A surface that points may not pass and do not stick to: normal . x >= offset.
struct Wall {
  Eigen::Vector3d normal;
  double offset = 0.0;
};

/// Calls onStep(t, state) after each step of h seconds. Uses Moreau's scheme: a point that would pass the
/// wall gets the speed that brings it to the wall. The order is 1, so steps must be small.
void integrateAgainst(const SpringSystem& system, const Wall& wall, double seconds, double h,
                      const std::function<void(double, const State&)>& onStep);

// --- signals ---

/// A signal sampled once per tick. Between the samples it is the polynomial of degree 5 through the nearest
/// six samples. With 15 samples per period, the error is 1e-7 of a period.
struct Signal {
  double dt = 0.0;
  std::vector<double> samples;

  double at(double t) const;
  double end() const { return dt * static_cast<double>(samples.size() - 1); }
};

/// Returns the times at which the signal falls through zero.
std::vector<double> fallsThroughZero(const Signal& signal);

/// Returns the mean time between its falls through zero; infinite if there are fewer than two.
double period(const Signal& signal);

/// Returns the largest magnitude in [from, to].
double amplitude(const Signal& signal, double from, double to);

/// Returns the first time after `from` at which the signal crosses `level`, or infinity.
double firstReaches(const Signal& signal, double level, double from = 0.0);

}  // namespace limber::bench
