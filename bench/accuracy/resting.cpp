// SPDX-License-Identifier: Zlib
#include "accuracy/networks.h"
#include "accuracy/resting_cube.h"
#include "accuracy/rigid_bodies.h"
#include "accuracy/scene_list.h"

#include <algorithm>
#include <limits>

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

/// A cube on an incline of tan = fraction mu, simulated by inclined gravity. It settles for one second and is
/// measured for another.
Scene incline(double fraction) {
  const double mu = 0.5, angle = std::atan(fraction * mu);
  Scene scene;
  scene.kind = Kind::Contact;
  scene.seconds = 2.0;
  scene.keepSeconds = 1.0;
  scene.gravity = kGravity * Eigen::Vector3d(std::sin(angle), -std::cos(angle), 0);
  BodySetup body = restingCube(1e4);
  body.settings.friction = mu;
  scene.bodies = {body};
  scene.addRigidBodies = [](RigidBodies& rigid, btDiscreteDynamicsWorld& world) {
    addFloor(rigid, world, Floor::Box, 1.0);
  };
  const auto at = [](const Trace& trace, double timeFraction) {
    const auto frame = std::lround(timeFraction * static_cast<double>(trace.frames.size() - 1));
    return trace.frames[static_cast<std::size_t>(frame)].positions[0].row(0).mean();
  };
  if (fraction < 1) {
    scene.name = "incline 0.97 mu";
    scene.measures = {"creep"};
    scene.judge = [at](const Trace& t) { return std::vector<double>{std::abs(at(t, 1.0) - at(t, 0.0))}; };
  } else {
    // x'' = g (sin - mu cos), from three positions half a second apart
    const double exact = kGravity * (std::sin(angle) - mu * std::cos(angle));
    scene.name = "incline 1.03 mu";
    scene.measures = {"acceleration"};
    scene.judge = [at, exact](const Trace& t) {
      return std::vector<double>{relativeError((at(t, 0.0) - 2 * at(t, 0.5) + at(t, 1.0)) / 0.25, exact)};
    };
  }
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
}

}  // namespace limber::bench
