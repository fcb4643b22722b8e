// SPDX-License-Identifier: Zlib
#include "accuracy/bodies.h"
#include "accuracy/scene.h"
#include "accuracy/signals.h"
#include "accuracy/spring_system.h"
#include "text_format.h"

#include <algorithm>

namespace limber::bench {
namespace {

constexpr double kElongation = 0.1;  // m, at the start

Signal coordinate(const Trace& trace, Eigen::Index row, Eigen::Index point, double zero) {
  Signal signal{trace.dt, {}};
  for (const Frame& frame : trace.frames) signal.samples.push_back(frame.positions[0](row, point) - zero);
  return signal;
}

/// A mass on a pinned spring:  T = 2 pi sqrt(m / k).  Without oscillation both errors are 1.
Scene oscillator() {
  const double mass = 0.1, stiffness = 16.0, exact = 2 * M_PI * std::sqrt(mass / stiffness);
  Scene scene;
  scene.name = "oscillator";
  scene.seconds = wholeTicks(10.5 * exact);
  scene.gravity.setZero();
  BodySetup body = bodyOf(pairNetwork(), 2 * mass, stiffness);
  body.pins = {0};
  body.positions = Eigen::Matrix3Xd::Zero(3, 2);
  body.positions(0, 1) = 1.0 + kElongation;
  scene.bodies = {body};
  scene.measures = {"period", "amplitude"};
  scene.ordered = true;
  scene.periodTolerance = 1e-4;
  scene.judge = [exact](const Trace& trace) {
    const Signal x = coordinate(trace, 0, 1, 1.0);
    const double remaining = amplitude(x, 9.4 * exact, 10.4 * exact) / kElongation;
    const double measured = period(x);
    return std::vector<double>{std::isfinite(measured) ? std::abs(measured / exact - 1) : 1.0,
                               std::abs(remaining - 1)};
  };
  return scene;
}

/// Returns the period of a pendulum of length l released at the angle a:  T = 4 sqrt(l / g) K(sin(a / 2)).
/// K(k) is pi / (2 agm(1, sqrt(1 - k^2))).
double pendulumPeriod(double length, double angle) {
  double a = 1.0, b = std::cos(angle / 2);
  for (int i = 0; i < 30; ++i) {
    const double mean = 0.5 * (a + b);
    b = std::sqrt(a * b);
    a = mean;
  }
  return 2 * M_PI * std::sqrt(length / kGravity) / a;
}

Eigen::Vector3d rodOf(const Eigen::Matrix3Xd& points) { return points.col(1) - points.col(0); }

/// Returns the rod's period, by fine integration of the equations of mass and spring.
double springPendulumPeriod(const BodySetup& body, const Scene& scene) {
  SpringSystem system = systemOf(body, scene.gravity);
  Signal x{1.0 / 120, {}};
  for (double t = 0; t < scene.seconds; t += x.dt) {
    x.samples.push_back(system.start.positions(0, 1));
    const State next = integrate(system, x.dt);
    system.start.positions = next.x;
    system.start.velocities = next.v;
  }
  return period(x);
}

/// Returns the largest deviation of the rod's length from  l + (m g / k)(3 cos phi - 2 cos a),  which
/// supports weight and centripetal force, over the largest stretch.
double stretchError(const Trace& trace, double sag, double angle) {
  double worst = 0.0;
  for (const Frame& frame : trace.frames) {
    const Eigen::Vector3d rod = rodOf(frame.positions[0]);
    const double cosine = -rod.y() / rod.norm();
    worst = std::max(worst, std::abs(rod.norm() - 1.0 - sag * (3 * cosine - 2 * std::cos(angle))));
  }
  return worst / (sag * (3 - 2 * std::cos(angle)));
}

/// A pendulum that starts with the stretch of its weight, so that the rod's length hardly oscillates.
Scene pendulum() {
  const double mass = 1.0, stiffness = 1e6, angle = M_PI / 3, sag = mass * kGravity / stiffness;
  Scene scene;
  scene.name = "stiff pendulum";
  scene.seconds = wholeTicks(5.3 * pendulumPeriod(1.0, angle));
  BodySetup body = bodyOf(pairNetwork(), 2 * mass, stiffness);
  body.pins = {0};
  const double length = 1.0 + sag * std::cos(angle);
  body.positions = Eigen::Matrix3Xd::Zero(3, 2);
  body.positions.col(1) = length * Eigen::Vector3d(std::sin(angle), -std::cos(angle), 0);
  const double exact = springPendulumPeriod(body, scene);
  scene.bodies = {body};
  scene.measures = {"period", "stretch"};
  scene.judge = [=](const Trace& trace) {
    const double measured = period(coordinate(trace, 0, 1, 0.0));
    return std::vector<double>{std::isfinite(measured) ? std::abs(measured / exact - 1) : 1.0,
                               stretchError(trace, sag, angle)};
  };
  scene.remark = format("period %.7f s; of a rigid rod, by the elliptic integral, %.7f s", exact,
                        pendulumPeriod(1.0, angle));
  return scene;
}

}  // namespace

void addOscillators(std::vector<Scene>& scenes, bool) {
  scenes.push_back(oscillator());
  scenes.push_back(pendulum());
}

}  // namespace limber::bench
