// SPDX-License-Identifier: Zlib
#include "accuracy/accuracy_scene.h"
#include "results.h"
#include "support/small_meshes.h"

#include <limber/network_builder.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace limber::bench {

namespace {

double meanX(const Frame& frame, std::size_t body) { return frame.positions[body].row(0).mean(); }

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

/// Returns the exact mean position of the points, across the wall, every so many steps of h.
Signal exactMotion(const BodySetup& body, const Eigen::Vector3d& gravity, const Wall& wall, double seconds,
                   double h, int stepsPerSample) {
  Eigen::Index axis = 0;
  wall.normal.maxCoeff(&axis);
  Signal motion{stepsPerSample * h, {startOf(body).positions.row(axis).mean()}};
  long step = 0;
  integrateAgainst(systemOf(body, gravity), wall, seconds, h, [&](double, const State& s) {
    if (++step % stepsPerSample == 0) motion.samples.push_back(s.x.row(axis).mean());
  });
  return motion;
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
  scene.addRigidBodies = [](RigidBodies& rigid) { addBox(rigid, {1, 2, 2}, 0, {-1, 0, 0}, 0); };
  const Wall wall{Eigen::Vector3d::UnitX(), kRadius};
  const Signal exactSignal = exactMotion(body, scene.gravity, wall, scene.seconds, 5e-6, 200);
  const auto errorOf = [exactSignal, mass = body.settings.totalMass](double Impact::*value) {
    return [=](const Trace& trace) {
      const Signal position = signalOf(trace, [](const Frame& frame) { return meanX(frame, 0); });
      const Signal exact = resampled(exactSignal, trace.dt, position.samples.size());
      return relativeError(impactOf(speedOf(position), mass).*value, impactOf(speedOf(exact), mass).*value);
    };
  };
  scene.measures = {{"rebound", errorOf(&Impact::rebound)},
                    {"contact time", errorOf(&Impact::contactTime)},
                    {"force", errorOf(&Impact::force)}};
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

Scene sceneOn(Floor floor, double friction) {
  Scene scene;
  scene.kind = Kind::Contact;
  scene.limberOnly = floor != Floor::Box;
  scene.addRigidBodies = [=](RigidBodies& rigid) { addFloor(rigid, floor, friction); };
  return scene;
}

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
  Scene scene = sceneOn(Floor::Box, 0.0);
  scene.ordered = true;
  scene.seconds = wholeTicks(0.6);
  BodySetup body = bodyOf(cubeNetwork(), 1.0, stiffness, 0.04 * std::sqrt(stiffness / 8));
  body.settings.pointRadius = radius;
  body.settings.friction = 0.0;
  body.settings.position.y() = rest + 0.5;
  scene.bodies = {body};
  const Wall floor{Eigen::Vector3d::UnitY(), radius};
  const double exact = reboundOf(exactMotion(body, scene.gravity, floor, scene.seconds, 1e-6, 1000), rest);
  const auto error = [=](const Trace& trace) {
    const Signal heights = signalOf(trace, [](const Frame& f) { return f.positions[0].row(1).mean(); });
    return relativeError(reboundOf(heights, rest), exact);
  };
  scene.measures = {{"rebound", error}};
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
  Scene scene = sceneOn(floor, 0.0);
  scene.seconds = 6.0;
  scene.keepSeconds = 1.0;
  BodySetup body = restingCube(std::pow(10.0, exponent));
  body.settings.friction = 0.0;
  scene.bodies = {body};
  const double exact = restHeight(body, 0.0);
  const double weight = kGravity * body.settings.totalMass;
  scene.measures = {
      {"height", [=](const Trace& t) { return std::abs(topOf(t.last().positions[0]) - exact); }},
      {"force", [=](const Trace& t) { return forceError(t, weight); }}};
  return scene;
}

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

/// Compares the acceleration of a body with the exact one.
Measure accelerationError(const char* name, std::size_t body, double exact) {
  return {name, [=](const Trace& trace) { return relativeError(accelerationOf(trace, body), exact); }};
}

/// A cube on an incline of tan = fraction mu, simulated by inclined gravity. It settles for one second and is
/// measured for another.
Scene incline(double fraction) {
  const double mu = 0.5, angle = std::atan(fraction * mu);
  Scene scene = sceneOn(Floor::Box, 1.0);
  scene.seconds = 2.0;
  scene.keepSeconds = 1.0;
  scene.gravity = inclined(angle);
  BodySetup body = restingCube(1e4);
  body.settings.friction = mu;
  scene.bodies = {body};
  const Measure creep{"creep",
                      [](const Trace& t) { return std::abs(meanX(t.last(), 0) - meanX(t.frames[0], 0)); }};
  scene.measures = {fraction < 1 ? creep
                                 : accelerationError("acceleration", 0, slidingAcceleration(angle, mu))};
  return scene;
}

// --- floors in one piece and in tiles ----------------------------------------------------------------------

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
  const auto speedError = [speeds](const Trace& trace) {
    double worst = 0.0;
    for (std::size_t i = 0; i < speeds.size(); ++i)
      worst = std::max(worst, relativeError(trace.last().velocities[i].row(0).mean(), speeds[i]));
    return worst;
  };
  const auto highestHop = [](const Trace& trace) {
    double highest = 0.0;
    for (const Frame& frame : trace.frames)
      for (const Eigen::Matrix3Xd& x : frame.positions)
        highest = std::max(highest, x.row(1).minCoeff() - kCubeRadius);
    return highest;
  };
  scene.measures = {{"speed", speedError}, {"hop", highestHop}};
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
  scene.measures = {accelerationError("cube", 0, slidingAcceleration(angle, mu)),
                    accelerationError("cloth", 1, slidingAcceleration(angle, 0.0))};
  return scene;
}

/// A ball that is thrown along the floor, slips and rolls, beside the same ball on one box. Measures how far
/// the two are apart after a second, in radii.
Scene rollOn(Floor floor) {
  constexpr double kBallRadius = 0.25;          // m
  const Eigen::Vector3d toReference(0, 0, 16);  // m
  TriangleMesh mesh = small_meshes::icosphere(1);
  for (Eigen::Vector3d& p : mesh.positions) p *= kBallRadius;
  Scene scene = sceneOn(floor, 1.0);
  scene.limberOnly = true;
  BodySetup ball = bodyOf(valueOf(buildNetwork(mesh)), 1.0, 1e4, 10.0);
  ball.settings.pointRadius = kCubeRadius;
  ball.settings.position = {0.1, kBallRadius + kCubeRadius, 0.05};
  ball.settings.linearVelocity = {4.0, 0, 0};
  scene.bodies = {ball, ball};
  scene.bodies[1].settings.position += toReference;
  scene.addRigidBodies = [=](RigidBodies& rigid) {
    addFloor(rigid, floor, 1.0);
    addBox(rigid, {20, 1, 2}, 0, toReference - Eigen::Vector3d(0, 1, 0), 1.0);
  };
  const auto apart = [=](const Trace& trace) {
    const auto& x = trace.last().positions;
    return (x[0].rowwise().mean() + toReference - x[1].rowwise().mean()).norm() / kBallRadius;
  };
  scene.measures = {{"path", apart}};
  return scene;
}

// --- rigid partners ---

const Eigen::Vector3d kBox = {0.7, 0.1, 0.7};  // half sizes, m
constexpr double kStiffness = 1e4;

/// Returns a scene on a floor that settles until heightOf() the last frame is measured.
Scene settling(double exact, const std::function<double(const Frame&)>& heightOf) {
  Scene scene = sceneOn(Floor::Box, 1.0);
  scene.seconds = 6.0;
  scene.keepSeconds = 0.0;
  scene.measures = {{"height", [=](const Trace& t) { return std::abs(heightOf(t.last()) - exact); }}};
  return scene;
}

double topOfLast(const Frame& frame) { return topOf(frame.positions.back()); }

/// A cube on a free box; measures the height of the cube's top.
Scene cubeOnBox(double mass) {
  BodySetup body = restingCube(kStiffness);
  Scene scene = settling(2 * kBox.y() + restHeight(body, 0.0), topOfLast);
  body.settings.position.y() += 2 * kBox.y();
  scene.bodies = {body};
  scene.addRigidBodies = [mass](RigidBodies& rigid) {
    addFloor(rigid, Floor::Box, 1.0);
    addBox(rigid, kBox, mass, {0.1, kBox.y(), 0.05}, 1.0);
  };
  return scene;
}

/// A free box on a cube; measures the height of the box's centre.
Scene boxOnCube(double mass) {
  const BodySetup body = restingCube(kStiffness);
  Scene scene = settling(restHeight(body, mass * kGravity) + kCubeRadius + kBox.y(),
                         [](const Frame& frame) { return frame.boxes[0].y(); });
  scene.bodies = {body};
  scene.addRigidBodies = [mass](RigidBodies& rigid) {
    addFloor(rigid, Floor::Box, 1.0);
    addBox(rigid, kBox, mass, {0.1, 1 + 2 * kCubeRadius + kBox.y(), 0.05}, 1.0);
  };
  return scene;
}

/// Cubes stacked corner on corner; measures the height of the topmost cube's top.
Scene stack(int count) {
  const BodySetup lowest = restingCube(kStiffness);
  double exact = -kCubeRadius;
  std::vector<BodySetup> bodies;
  for (int i = 0; i < count; ++i) {
    BodySetup body = lowest;
    body.settings.position.y() += i * (1 + 2 * kCubeRadius);
    bodies.push_back(body);
    exact += restHeight(lowest, (count - 1 - i) * kGravity * lowest.settings.totalMass) + kCubeRadius;
  }
  Scene scene = settling(exact, topOfLast);
  scene.bodies = bodies;
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
