// SPDX-License-Identifier: Zlib
#include "accuracy/bodies.h"
#include "contact/contact_scene.h"
#include "stability/case_parts.h"

#include <cmath>

namespace limber::bench {
namespace {

constexpr double kStiffness = 1000.0;  // N/m
constexpr double kDamping = 2.0;       // N s/m, a tenth of the critical damping of a spring and its points
constexpr double kMass = 0.8;          // kg
constexpr double kRadius = 0.02;       // m
constexpr double kCubeSpacing = 2.0;   // m from cube to cube, of 1 m
constexpr double kDrop = 0.5;          // m
constexpr double kClearance = 1e-3;    // m between a resting cube and the floor at first
constexpr double kHigh = 100.0;        // m: no body comes near the floor during the measurement

std::uint32_t countOf(Crowd crowd, bool quick) {
  const std::uint32_t full[] = {64, 512, 4096, 2560}, few[] = {2, 4, 8, 6};
  return (quick ? few : full)[static_cast<int>(crowd)];
}

double heightOf(Role role) {
  if (role == Role::Airborne) return kHigh;
  return role == Role::Landing ? kDrop : kClearance;
}

/// Returns cubes on a square grid, each rotated about its vertical axis: all land flat, and in the same tick.
std::vector<BodySetup> cubes(Role role, std::uint32_t count) {
  Dice dice(1);
  const auto columns = static_cast<std::uint32_t>(std::ceil(std::sqrt(double(count))));
  const double half = 0.5 * kCubeSpacing * (columns - 1);
  BodySetup cube = bodyOf(closedCubeNetwork(), kMass, kStiffness, kDamping);
  cube.settings.pointRadius = kRadius;
  cube.drag = 1.0;
  cube.maySleep = role == Role::Asleep;
  std::vector<BodySetup> bodies;
  for (std::uint32_t i = 0; i < count; ++i) {
    cube.settings.position = {kCubeSpacing * (i % columns) - half, 0.5 + kRadius + heightOf(role),
                              kCubeSpacing * (i / columns) - half};
    cube.settings.rotation = Eigen::AngleAxisd(dice.within(0.7), Eigen::Vector3d::UnitY());
    bodies.push_back(cube);
  }
  return bodies;
}

void setTimes(ContactScene& scene, bool quick) {
  if (scene.role == Role::Landing) {
    scene.settleTicks = 0;
    scene.turn = scene.measuredTicks;  // no change of engine: the worst tick must not be one with cold caches
  }
  // loose spheres have landed by then, and damped cubes have stopped
  if (scene.role == Role::Rest) scene.settleTicks = 60;
  // Bullet requires two seconds of rest
  if (scene.role == Role::Asleep) scene.settleTicks = 240;
  if (quick && scene.role == Role::Airborne) scene.measuredTicks = 20;
}

ContactScene cubeScene(Role role, Crowd crowd, bool quick) {
  const std::uint32_t count = countOf(crowd, quick);
  ContactScene scene;
  scene.name = std::to_string(count) + " cubes " + nameOf(role);
  scene.role = role;
  scene.crowd = crowd;
  scene.bodies = cubes(role, count);
  const double halfWidth = 0.5 * kCubeSpacing * std::ceil(std::sqrt(double(count))) + 5.0;
  scene.addRigidBodies = [halfWidth](RigidBodies& rigid, btDiscreteDynamicsWorld& world) {
    addBox(rigid, world, {halfWidth, 1, halfWidth}, 0, {0, -1, 0}, 0.5);
  };
  scene.distance = [](const Eigen::Vector3d& x) { return x.y(); };
  scene.withOthers = crowd != Crowd::RealTime;
  setTimes(scene, quick);
  return scene;
}

}  // namespace

void addCubeScenes(std::vector<ContactScene>& scenes, bool quick) {
  for (const Role role : {Role::Airborne, Role::Landing, Role::Rest, Role::Asleep})
    for (const Crowd crowd : {Crowd::Small, Crowd::Middle, Crowd::Large})
      scenes.push_back(cubeScene(role, crowd, quick));
  scenes.push_back(cubeScene(Role::Rest, Crowd::RealTime, quick));
}

}  // namespace limber::bench
