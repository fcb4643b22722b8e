// SPDX-License-Identifier: Zlib
#include "accuracy/bodies.h"
#include "accuracy/rigid_bodies.h"
#include "accuracy/scene.h"
#include "accuracy/signals.h"
#include "accuracy/spring_system.h"
#include "text_format.h"

#include <algorithm>

namespace limber::bench {
namespace {

// --- a bar of springs against a wall ---

constexpr double kSpeed = 0.5, kRadius = 0.0125, kGap = 0.02, kPointMass = 0.01;

/// Properties of an impact, computed from the speed of the mass centre.
struct Impact {
  double rebound = 0.0;      ///< m/s, at the end
  double contactTime = 0.0;  ///< s
  double force = 0.0;        ///< N, in the middle of the contact
};

/// During the contact the speed changes from -v to v on a nearly straight line, most exactly in its middle.
/// The slope there gives the force, and twice the time between -v/2 and v/2 is the contact time.
Impact impactOf(const Signal& speed, double mass) {
  const auto timeAt = [&](double fraction) { return firstReaches(speed, fraction * kSpeed); };
  return {speed.samples.back(), 2 * (timeAt(0.5) - timeAt(-0.5)),
          mass * 0.5 * kSpeed / (timeAt(0.25) - timeAt(-0.25))};
}

/// Returns the mean speeds between samples. They can be computed from the positions of every engine.
Signal speedOf(const Signal& position) {
  Signal speed{position.dt, {}};
  for (std::size_t i = 1; i < position.samples.size(); ++i)
    speed.samples.push_back((position.samples[i] - position.samples[i - 1]) / position.dt);
  return speed;
}

/// Returns the exact position of the mass centre at every millisecond.
Signal exactPosition(const BodySetup& body, double seconds) {
  const Wall wall{Eigen::Vector3d::UnitX(), kRadius};
  const double h = 5e-6;
  Signal position{200 * h, {startOf(body).positions.row(0).mean()}};
  long step = 0;
  integrateAgainst(systemOf(body, Eigen::Vector3d::Zero()), wall, seconds, h, [&](double, const State& s) {
    if (++step % 200 == 0) position.samples.push_back(s.x.row(0).mean());
  });
  return position;
}

/// Returns the signal sampled once per tick.
Signal resampled(const Signal& signal, double dt, std::size_t count) {
  Signal result{dt, {}};
  for (std::size_t i = 0; i < count; ++i) result.samples.push_back(signal.at(dt * static_cast<double>(i)));
  return result;
}

std::string impactRemark(const Impact& exact) {
  return format("contact %.4f s, force %.4f N, rebound %.4f m/s", exact.contactTime, exact.force,
                exact.rebound);
}

/// A body that flies against a wall at right angles, without gravity or friction.
Scene againstWall(const std::string& name, const SharedNetwork& network, double stiffness) {
  Scene scene;
  scene.name = name;
  scene.kind = Kind::Contact;
  scene.ordered = true;
  scene.gravity.setZero();
  scene.seconds = wholeTicks(0.4);
  BodySetup body = bodyOf(network, kPointMass * static_cast<double>(network->restPoints.size()), stiffness);
  body.settings.pointRadius = kRadius;
  body.settings.friction = 0.0;
  body.settings.position.x() = kRadius + kGap;
  body.settings.linearVelocity.x() = -kSpeed;
  scene.bodies = {body};
  scene.addRigidBodies = [](RigidBodies& rigid, btDiscreteDynamicsWorld& world) {
    addBox(rigid, world, {1, 2, 2}, 0, {-1, 0, 0}, 0);
  };
  const Signal exactSignal = exactPosition(body, scene.seconds);
  scene.measures = {"rebound", "contact time", "force"};
  scene.judge = [exactSignal, mass = body.settings.totalMass](const Trace& trace) {
    Signal position{trace.dt, {}};
    for (const Frame& frame : trace.frames) position.samples.push_back(frame.positions[0].row(0).mean());
    const Impact measured = impactOf(speedOf(position), mass);
    const Impact exact = impactOf(speedOf(resampled(exactSignal, trace.dt, position.samples.size())), mass);
    return std::vector<double>{relativeError(measured.rebound, exact.rebound),
                               relativeError(measured.contactTime, exact.contactTime),
                               relativeError(measured.force, exact.force)};
  };
  scene.remark = impactRemark(impactOf(speedOf(exactSignal), body.settings.totalMass));
  return scene;
}

/// A line of springs, as in one dimension. The smallest sideways force buckles it.
Scene lineAgainstWall() {
  const int links = 32;
  const double stiffness = 1024.0, waves = std::sqrt(kPointMass / stiffness);  // s a link
  Scene scene = againstWall("bar against a wall", barNetwork(links), stiffness);
  scene.remark += format("; a continuous bar (2 L / c, sqrt(k m) v, v): %.4f s, %.4f N, %.4f m/s",
                         2 * (links + 1) * waves, std::sqrt(stiffness * kPointMass) * kSpeed, kSpeed);
  return scene;
}

/// A bar that its braces keep straight.
Scene latticeAgainstWall() {
  return againstWall("braced bar against a wall", latticeNetwork(17, 2, 2, 1.0 / 16), 200.0);
}

// --- a cube dropped onto the floor ---

/// Returns the height over `rest` that a signal of heights reaches after its first minimum: the top of the
/// parabola through the highest sample and its neighbours, which is exact in free flight.
double reboundOf(const Signal& height, double rest) {
  const auto& y = height.samples;
  std::size_t low = 1;
  while (low + 1 < y.size() && y[low + 1] < y[low]) ++low;
  std::size_t top = low;
  while (top + 1 < y.size() && y[top + 1] > y[top]) ++top;
  if (top == low || top + 1 >= y.size()) return y[top] - rest;
  const double curvature = y[top - 1] - 2 * y[top] + y[top + 1], slope = y[top + 1] - y[top - 1];
  return y[top] - slope * slope / (8 * curvature) - rest;
}

Scene droppedCube(int exponent) {
  const double stiffness = std::pow(10.0, exponent), radius = 0.02, rest = 0.5 + radius;
  Scene scene;
  scene.name = "dropped cube 1e" + std::to_string(exponent);
  scene.kind = Kind::Contact;
  scene.ordered = true;
  scene.seconds = wholeTicks(0.6);
  BodySetup body = bodyOf(cubeNetwork(), 1.0, stiffness, 0.04 * std::sqrt(stiffness / 8));
  body.settings.pointRadius = radius;
  body.settings.friction = 0.0;
  body.settings.position.y() = rest + 0.5;
  scene.bodies = {body};
  scene.addRigidBodies = [](RigidBodies& rigid, btDiscreteDynamicsWorld& world) {
    addFloor(rigid, world, Floor::Box, 0);
  };
  Signal height{1e-3, {}};
  const double h = 1e-6;
  long step = 0;
  integrateAgainst(systemOf(body, scene.gravity), {Eigen::Vector3d::UnitY(), radius}, scene.seconds, h,
                   [&](double, const State& s) {
                     if (++step % 1000 == 0) height.samples.push_back(s.x.row(1).mean());
                   });
  const double exact = reboundOf(height, rest);
  scene.measures = {"rebound"};
  scene.judge = [=](const Trace& trace) {
    Signal heights{trace.dt, {}};
    for (const Frame& frame : trace.frames) heights.samples.push_back(frame.positions[0].row(1).mean());
    return std::vector<double>{relativeError(reboundOf(heights, rest), exact)};
  };
  scene.remark = format("rebound %.5f m from 0.5 m, by steps of 1 us", exact);
  return scene;
}

}  // namespace

void addImpacts(std::vector<Scene>& scenes, bool quick) {
  scenes.push_back(lineAgainstWall());
  scenes.push_back(latticeAgainstWall());
  for (int exponent = 3; exponent <= 5; exponent += quick ? 2 : 1) scenes.push_back(droppedCube(exponent));
}

}  // namespace limber::bench
