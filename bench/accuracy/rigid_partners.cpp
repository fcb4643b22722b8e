// SPDX-License-Identifier: Zlib
#include "accuracy/bodies.h"
#include "accuracy/rigid_bodies.h"
#include "accuracy/scene.h"

#include <cmath>

namespace limber::bench {
namespace {

const Eigen::Vector3d kBox = {0.7, 0.1, 0.7};  // half sizes, m
constexpr double kStiffness = 1e4;

Scene settling(const std::string& name) {
  Scene scene;
  scene.name = name;
  scene.kind = Kind::Contact;
  scene.seconds = 6.0;
  scene.keepSeconds = 0.0;
  scene.measures = {"height"};
  return scene;
}

/// A cube on a free box; measures the height of the cube's top.
Scene cubeOnBox(double mass) {
  Scene scene = settling("cube on a free box of " + std::to_string(std::lround(mass)) + " kg");
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
  Scene scene = settling("free box of " + std::to_string(std::lround(mass)) + " kg on a cube");
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
  Scene scene = settling("stack of " + std::to_string(count) + " cubes");
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

}  // namespace

void addRigidPartners(std::vector<Scene>& scenes, bool quick) {
  scenes.push_back(cubeOnBox(1.0));
  scenes.push_back(boxOnCube(1.0));
  if (!quick) {
    scenes.push_back(cubeOnBox(10.0));
    scenes.push_back(boxOnCube(10.0));
  }
  scenes.push_back(stack(5));
}

}  // namespace limber::bench
