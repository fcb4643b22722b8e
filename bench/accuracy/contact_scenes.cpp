// SPDX-License-Identifier: Zlib
#include "accuracy/accuracy_scene.h"
#include "results.h"
#include "scene/bodies.h"
#include "scene/rigid_bodies.h"
#include "scene/signals.h"
#include "scene/spring_system.h"
#include "support/small_meshes.h"

#include <limber/network_builder.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace limber::bench {

// --- impacts ---

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
Scene againstWall(const SharedNetwork& network, double stiffness) {
  Scene scene;
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
  Scene scene = againstWall(barNetwork(links), stiffness);
  scene.remark += format("; a continuous bar (2 L / c, sqrt(k m) v, v): %.4f s, %.4f N, %.4f m/s",
                         2 * (links + 1) * waves, std::sqrt(stiffness * kPointMass) * kSpeed, kSpeed);
  return scene;
}

/// A bar that its braces keep straight.
Scene latticeAgainstWall() { return againstWall(latticeNetwork(17, 2, 2, 1.0 / 16), 200.0); }

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

// --- resting and sliding on floors ---

/// Returns the error of the mean contact force over the frames, relative to the weight; NaN for an engine
/// that does not report it.
double forceError(const Trace& trace, double weight) {
  double impulse = 0.0;
  for (const Frame& frame : trace.frames) impulse += frame.contactImpulse;
  if (impulse == 0.0) return std::numeric_limits<double>::quiet_NaN();
  return relativeError(impulse / (trace.dt * static_cast<double>(trace.frames.size())), weight);
}

Scene restOn(Floor floor, int exponent) {
  Scene scene;
  scene.kind = Kind::Contact;
  scene.seconds = 6.0;
  scene.keepSeconds = 1.0;
  scene.limberOnly = floor != Floor::Box;
  BodySetup body = restingCube(std::pow(10.0, exponent));
  body.settings.friction = 0.0;
  scene.bodies = {body};
  scene.addRigidBodies = [floor](RigidBodies& rigid, btDiscreteDynamicsWorld& world) {
    addFloor(rigid, world, floor, 0);
  };
  const double exact = restHeight(body, 0.0);
  scene.measures = {"height", "force"};
  scene.judge = [=](const Trace& trace) {
    return std::vector<double>{std::abs(topOf(trace.last().positions[0]) - exact),
                               forceError(trace, kGravity * body.settings.totalMass)};
  };
  return scene;
}

double meanX(const Frame& frame, std::size_t body) { return frame.positions[body].row(0).mean(); }

/// Returns the acceleration along x (m/s^2) from the first, the middle and the last frame.
double accelerationOf(const Trace& trace, std::size_t body) {
  const std::size_t count = trace.frames.size() - 1;
  const double half = 0.5 * trace.dt * static_cast<double>(count);
  return (meanX(trace.frames[0], body) - 2 * meanX(trace.frames[count / 2], body) +
          meanX(trace.last(), body)) /
         (half * half);
}

Eigen::Vector3d inclined(double angle) {
  return kGravity * Eigen::Vector3d(std::sin(angle), -std::cos(angle), 0);
}

/// x'' = g (sin - mu cos)
double slidingAcceleration(double angle, double mu) {
  return kGravity * (std::sin(angle) - mu * std::cos(angle));
}

/// A cube on an incline of tan = fraction mu, simulated by inclined gravity. It settles for one second and is
/// measured for another.
Scene incline(double fraction) {
  const double mu = 0.5, angle = std::atan(fraction * mu);
  Scene scene;
  scene.kind = Kind::Contact;
  scene.seconds = 2.0;
  scene.keepSeconds = 1.0;
  scene.gravity = inclined(angle);
  BodySetup body = restingCube(1e4);
  body.settings.friction = mu;
  scene.bodies = {body};
  scene.addRigidBodies = [](RigidBodies& rigid, btDiscreteDynamicsWorld& world) {
    addFloor(rigid, world, Floor::Box, 1.0);
  };
  if (fraction < 1) {
    scene.measures = {"creep"};
    scene.judge = [](const Trace& t) {
      return std::vector<double>{std::abs(meanX(t.last(), 0) - meanX(t.frames[0], 0))};
    };
  } else {
    scene.measures = {"acceleration"};
    scene.judge = [exact = slidingAcceleration(angle, mu)](const Trace& t) {
      return std::vector<double>{relativeError(accelerationOf(t, 0), exact)};
    };
  }
  return scene;
}

// --- floors in one piece and in tiles ----------------------------------------------------------------------

Scene sceneOn(Floor floor, double friction) {
  Scene scene;
  scene.kind = Kind::Contact;
  scene.limberOnly = floor != Floor::Box;
  scene.addRigidBodies = [=](RigidBodies& rigid, btDiscreteDynamicsWorld& world) {
    addFloor(rigid, world, floor, friction);
  };
  return scene;
}

/// Frictionless cubes side by side that slide at 0.1 to 20 m/s for half a second: none loses speed or hops.
Scene slideOn(Floor floor) {
  const std::vector<double> speeds = {0.1, 1.0, 3.0, 20.0};
  Scene scene = sceneOn(floor, 0.0);
  scene.seconds = 0.5;
  for (std::size_t i = 0; i < speeds.size(); ++i) {
    BodySetup body = restingCube(1e4);
    body.settings.position += Eigen::Vector3d(0, 0, 2.0 * double(i) - 3.0);
    body.settings.linearVelocity = {speeds[i], 0, 0};
    body.settings.friction = body.drag = 0.0;
    scene.bodies.push_back(body);
  }
  scene.measures = {"speed", "hop"};
  scene.judge = [speeds](const Trace& trace) {
    double speed = 0.0, hop = 0.0;
    for (std::size_t i = 0; i < speeds.size(); ++i) {
      speed = std::max(speed, relativeError(trace.last().velocities[i].row(0).mean(), speeds[i]));
      for (const Frame& frame : trace.frames)
        hop = std::max(hop, frame.positions[i].row(1).minCoeff() - kCubeRadius);
    }
    return std::vector<double>{speed, hop};
  };
  return scene;
}

/// A cube with friction 0.2 and a frictionless cloth that slide down 30 degrees. They settle for half a
/// second and are measured for another.
Scene slopeOf(Floor floor) {
  const double mu = 0.2, angle = std::atan(1.0) * 2 / 3;
  Scene scene = sceneOn(floor, 1.0);
  scene.seconds = 1.0;
  scene.keepSeconds = 0.5;
  scene.gravity = inclined(angle);
  BodySetup cube = restingCube(1e4), cloth = bodyOf(clothNetwork(9), 0.2, 500.0, 0.1);
  cube.settings.position.z() = 1.5;
  cube.settings.friction = mu;
  cube.drag = 0.0;
  cloth.settings.position = {0.1, kCubeRadius, -1.5};
  cloth.settings.pointRadius = kCubeRadius;
  cloth.settings.friction = 0.0;
  scene.bodies = {cube, cloth};
  scene.measures = {"cube", "cloth"};
  scene.judge = [=](const Trace& t) {
    return std::vector<double>{relativeError(accelerationOf(t, 0), slidingAcceleration(angle, mu)),
                               relativeError(accelerationOf(t, 1), slidingAcceleration(angle, 0.0))};
  };
  return scene;
}

/// A ball that is thrown along the floor, slips and rolls, beside the same ball on one box. Measures how far
/// the two are apart after a second, in radii.
Scene rollOn(Floor floor) {
  constexpr double kBallRadius = 0.25;          // m
  const Eigen::Vector3d toReference(0, 0, 16);  // m
  TriangleMesh mesh = small_meshes::icosphere(1);
  for (Eigen::Vector3d& p : mesh.positions) p *= kBallRadius;
  const Result<SharedNetwork> network = buildNetwork(mesh);
  if (!network) throw std::runtime_error(network.error());
  Scene scene = sceneOn(floor, 1.0);
  scene.limberOnly = true;
  BodySetup ball = bodyOf(*network, 1.0, 1e4, 10.0);
  ball.settings.pointRadius = kCubeRadius;
  ball.settings.position = {0.1, kBallRadius + kCubeRadius, 0.05};
  ball.settings.linearVelocity = {4.0, 0, 0};
  scene.bodies = {ball, ball};
  scene.bodies[1].settings.position += toReference;
  scene.addRigidBodies = [=](RigidBodies& rigid, btDiscreteDynamicsWorld& world) {
    addFloor(rigid, world, floor, 1.0);
    addBox(rigid, world, {20, 1, 2}, 0, toReference - Eigen::Vector3d(0, 1, 0), 1.0);
  };
  scene.measures = {"path"};
  scene.judge = [=](const Trace& trace) {
    const auto centre = [&](std::size_t body) -> Eigen::Vector3d {
      return trace.last().positions[body].rowwise().mean();
    };
    return std::vector<double>{(centre(0) + toReference - centre(1)).norm() / kBallRadius};
  };
  return scene;
}

// --- rigid partners ---

const Eigen::Vector3d kBox = {0.7, 0.1, 0.7};  // half sizes, m
constexpr double kStiffness = 1e4;

Scene settling() {
  Scene scene;
  scene.kind = Kind::Contact;
  scene.seconds = 6.0;
  scene.keepSeconds = 0.0;
  scene.measures = {"height"};
  return scene;
}

/// A cube on a free box; measures the height of the cube's top.
Scene cubeOnBox(double mass) {
  Scene scene = settling();
  BodySetup body = restingCube(kStiffness);
  const double exact = 2 * kBox.y() + restHeight(body, 0.0);
  body.settings.position.y() += 2 * kBox.y();
  scene.bodies = {body};
  scene.addRigidBodies = [mass](RigidBodies& rigid, btDiscreteDynamicsWorld& world) {
    addFloor(rigid, world, Floor::Box, 1.0);
    addBox(rigid, world, kBox, mass, {0.1, kBox.y(), 0.05}, 1.0);
  };
  scene.judge = [exact](const Trace& trace) {
    return std::vector<double>{std::abs(topOf(trace.last().positions[0]) - exact)};
  };
  return scene;
}

/// A free box on a cube; measures the height of the box's centre.
Scene boxOnCube(double mass) {
  Scene scene = settling();
  const BodySetup body = restingCube(kStiffness);
  const double exact = restHeight(body, mass * kGravity) + kCubeRadius + kBox.y();
  scene.bodies = {body};
  scene.addRigidBodies = [mass](RigidBodies& rigid, btDiscreteDynamicsWorld& world) {
    addFloor(rigid, world, Floor::Box, 1.0);
    addBox(rigid, world, kBox, mass, {0.1, 1 + 2 * kCubeRadius + kBox.y(), 0.05}, 1.0);
  };
  scene.judge = [exact](const Trace& trace) {
    return std::vector<double>{std::abs(trace.last().boxes[0].y() - exact)};
  };
  return scene;
}

/// Cubes stacked corner on corner; measures the height of the topmost cube's top.
Scene stack(int count) {
  Scene scene = settling();
  const BodySetup lowest = restingCube(kStiffness);
  double exact = 0.0;
  for (int i = 0; i < count; ++i) {
    BodySetup body = lowest;
    body.settings.position.y() += i * (1 + 2 * kCubeRadius);
    scene.bodies.push_back(body);
    exact += restHeight(lowest, (count - 1 - i) * kGravity * lowest.settings.totalMass) + kCubeRadius;
  }
  exact -= kCubeRadius;
  scene.addRigidBodies = [](RigidBodies& rigid, btDiscreteDynamicsWorld& world) {
    addFloor(rigid, world, Floor::Box, 1.0);
  };
  scene.judge = [exact](const Trace& trace) {
    return std::vector<double>{std::abs(topOf(trace.last().positions.back()) - exact)};
  };
  return scene;
}

/// Adds the scenes whose results do not depend on how a floor is cut into parts.
void addTiledFloors(std::vector<SceneMaker>& scenes, bool quick) {
  std::vector<std::pair<Floor, std::string>> floors = {{Floor::Box, "one box"},
                                                       {Floor::CoarseMesh, "a coarse mesh"}};
  if (!quick)
    floors.insert(floors.end(), {{Floor::FineMesh, "a fine mesh"},
                                 {Floor::HeightField, "a height field"},
                                 {Floor::Boxes, "boxes"},
                                 {Floor::Compound, "a compound"},
                                 {Floor::Hulls, "hulls"}});
  for (const auto& [floor, name] : floors)
    scenes.push_back({"slide on " + name, [f = floor] { return slideOn(f); }});
  for (const auto& [floor, name] : floors)
    scenes.push_back({"slope of " + name, [f = floor] { return slopeOf(f); }});
  for (const auto& [floor, name] : floors)
    scenes.push_back({"roll on " + name, [f = floor] { return rollOn(f); }});
}

}  // namespace

std::vector<SceneMaker> contactScenes(bool quick) {
  std::vector<SceneMaker> scenes = {{"bar against a wall", lineAgainstWall},
                                    {"braced bar against a wall", latticeAgainstWall}};
  for (int exponent = 3; exponent <= 5; exponent += quick ? 2 : 1)
    scenes.push_back({"dropped cube 1e" + std::to_string(exponent), [=] { return droppedCube(exponent); }});
  const std::pair<Floor, const char*> floors[] = {{Floor::Plane, "plane"},
                                                  {Floor::Box, "box"},
                                                  {Floor::Hull, "hull"},
                                                  {Floor::TriangleMesh, "triangle mesh"}};
  for (const auto& [floor, name] : floors)
    for (int exponent = 3; exponent <= 6; exponent += quick ? 3 : 1)
      scenes.push_back({std::string("rest on a ") + name + " 1e" + std::to_string(exponent),
                        [f = floor, exponent] { return restOn(f, exponent); }});
  scenes.push_back({"incline 0.97 mu", [] { return incline(0.97); }});
  scenes.push_back({"incline 1.03 mu", [] { return incline(1.03); }});
  addTiledFloors(scenes, quick);
  scenes.push_back({"cube on a free box of 1 kg", [] { return cubeOnBox(1.0); }});
  scenes.push_back({"free box of 1 kg on a cube", [] { return boxOnCube(1.0); }});
  if (!quick) scenes.push_back({"cube on a free box of 10 kg", [] { return cubeOnBox(10.0); }});
  if (!quick) scenes.push_back({"free box of 10 kg on a cube", [] { return boxOnCube(10.0); }});
  scenes.push_back({"stack of 5 cubes", [] { return stack(5); }});
  return scenes;
}

}  // namespace limber::bench
