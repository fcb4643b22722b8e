// SPDX-License-Identifier: Zlib
#pragma once

#include "engines/body_start.h"

namespace limber::bench {

/// A set-up's points and springs as plain equations, in double: what every engine should solve. Written
/// without a line of Limber's, so that a common mistake cannot hide.
struct SpringSystem {
  std::vector<NetworkSpring> springs;
  BodyStart start;
  Eigen::Matrix3Xd free;  ///< 3 x #points, 1 where a coordinate may change, else 0
  Eigen::Matrix3Xd load;  ///< 3 x #points, N, gravity included
};

SpringSystem systemOf(const BodySetup& setup, const Eigen::Vector3d& gravity);

/// rad/s, above the fastest oscillation (Gershgorin's bound of the springs' matrix).
double frequencyBound(const SpringSystem& system);

struct State {
  Eigen::Matrix3Xd x, v;
};

/// The state after `seconds`, by the classical Runge-Kutta method of order 4, `stepsPerRadian` of the fastest
/// oscillation.
State integrate(const SpringSystem& system, double seconds, double stepsPerRadian = 20.0);

/// Where the points rest: a minimum of the energy, by Newton's method with a step-size control, from the
/// start's positions. Throws std::runtime_error when it finds none.
Eigen::Matrix3Xd equilibrium(const SpringSystem& system);

/// A surface that points may not pass and do not stick to: normal . x >= offset.
struct Wall {
  Eigen::Vector3d normal;
  double offset = 0.0;
};

/// Calls see(t, state) after each step of h seconds: Moreau's scheme, in which a point that would pass the
/// wall gets the speed that brings it there. Order 1: for steps so small that this is enough.
void integrateAgainst(const SpringSystem& system, const Wall& wall, double seconds, double h,
                      const std::function<void(double, const State&)>& see);

}  // namespace limber::bench
