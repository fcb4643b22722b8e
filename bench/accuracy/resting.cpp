// SPDX-License-Identifier: Zlib
#include "accuracy/bodies.h"
#include "accuracy/rigid_bodies.h"
#include "accuracy/scene.h"

#include "support/small_meshes.h"

#include <limber/network_builder.h>

#include <algorithm>
#include <limits>
#include <stdexcept>

namespace limber::bench {
namespace {

/// Returns the error of the mean contact force over the frames, relative to the weight; NaN for an engine
/// that does not report it.
double forceError(const Trace& trace, double weight) {
  double impulse = 0.0;
  for (const Frame& frame : trace.frames) impulse += frame.contactImpulse;
  if (impulse == 0.0) return std::numeric_limits<double>::quiet_NaN();
  return relativeError(impulse / (trace.dt * static_cast<double>(trace.frames.size())), weight);
}

Scene restOn(Floor floor, const std::string& name, int exponent) {
  Scene scene;
  scene.name = "rest on a " + name + " 1e" + std::to_string(exponent);
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
    scene.name = "incline 0.97 mu";
    scene.measures = {"creep"};
    scene.judge = [](const Trace& t) {
      return std::vector<double>{std::abs(meanX(t.last(), 0) - meanX(t.frames[0], 0))};
    };
  } else {
    scene.name = "incline 1.03 mu";
    scene.measures = {"acceleration"};
    scene.judge = [exact = slidingAcceleration(angle, mu)](const Trace& t) {
      return std::vector<double>{relativeError(accelerationOf(t, 0), exact)};
    };
  }
  return scene;
}

// --- floors in one piece and in tiles ----------------------------------------------------------------------

using NamedFloor = std::pair<Floor, std::string>;

Scene sceneOn(const NamedFloor& floor, double friction) {
  Scene scene;
  scene.kind = Kind::Contact;
  scene.limberOnly = floor.first != Floor::Box;
  scene.addRigidBodies = [=](RigidBodies& rigid, btDiscreteDynamicsWorld& world) {
    addFloor(rigid, world, floor.first, friction);
  };
  return scene;
}

/// Frictionless cubes side by side that slide at 0.1 to 20 m/s for half a second: none loses speed or hops.
Scene slideOn(const NamedFloor& floor) {
  const std::vector<double> speeds = {0.1, 1.0, 3.0, 20.0};
  Scene scene = sceneOn(floor, 0.0);
  scene.name = "slide on " + floor.second;
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
Scene slopeOf(const NamedFloor& floor) {
  const double mu = 0.2, angle = std::atan(1.0) * 2 / 3;
  Scene scene = sceneOn(floor, 1.0);
  scene.name = "slope of " + floor.second;
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
Scene rollOn(const NamedFloor& floor) {
  constexpr double kBallRadius = 0.25;          // m
  const Eigen::Vector3d toReference(0, 0, 16);  // m
  TriangleMesh mesh = small_meshes::icosphere(1);
  for (Eigen::Vector3d& p : mesh.positions) p *= kBallRadius;
  const Result<SharedNetwork> network = buildNetwork(mesh);
  if (!network) throw std::runtime_error(network.error());
  Scene scene = sceneOn(floor, 1.0);
  scene.limberOnly = true;
  scene.name = "roll on " + floor.second;
  BodySetup ball = bodyOf(*network, 1.0, 1e4, 10.0);
  ball.settings.pointRadius = kCubeRadius;
  ball.settings.position = {0.1, kBallRadius + kCubeRadius, 0.05};
  ball.settings.linearVelocity = {4.0, 0, 0};
  scene.bodies = {ball, ball};
  scene.bodies[1].settings.position += toReference;
  scene.addRigidBodies = [=](RigidBodies& rigid, btDiscreteDynamicsWorld& world) {
    addFloor(rigid, world, floor.first, 1.0);
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

}  // namespace

void addResting(std::vector<Scene>& scenes, bool quick) {
  const std::pair<Floor, const char*> floors[] = {{Floor::Plane, "plane"},
                                                  {Floor::Box, "box"},
                                                  {Floor::Hull, "hull"},
                                                  {Floor::TriangleMesh, "triangle mesh"}};
  for (const auto& [floor, name] : floors)
    for (int exponent = 3; exponent <= 6; exponent += quick ? 3 : 1)
      scenes.push_back(restOn(floor, name, exponent));
  scenes.push_back(incline(0.97));
  scenes.push_back(incline(1.03));
  std::vector<NamedFloor> tiled = {{Floor::Box, "one box"}, {Floor::CoarseMesh, "a coarse mesh"}};
  if (!quick)
    tiled.insert(tiled.end(), {{Floor::FineMesh, "a fine mesh"},
                               {Floor::HeightField, "a height field"},
                               {Floor::Boxes, "boxes"},
                               {Floor::Compound, "a compound"},
                               {Floor::Hulls, "hulls"}});
  for (const NamedFloor& floor : tiled) scenes.push_back(slideOn(floor));
  for (const NamedFloor& floor : tiled) scenes.push_back(slopeOf(floor));
  for (const NamedFloor& floor : tiled) scenes.push_back(rollOn(floor));
}

}  // namespace limber::bench
