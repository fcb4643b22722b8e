// SPDX-License-Identifier: Zlib
#include "contact/contact.h"
#include "support/small_meshes.h"

#include <limber/network_builder.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace limber::bench {

const char* nameOf(Role role) {
  const char* const names[] = {"airborne", "landing", "rest", "asleep", "cloth", "pile", "dense"};
  return names[static_cast<int>(role)];
}

// --- cubes on a floor or above ---

namespace {

constexpr double kStiffness = 1000.0;  // N/m
constexpr double kDamping = 2.0;       // N s/m, a tenth of the critical damping of a spring and its points
constexpr double kMass = 0.8;          // kg
constexpr double kRadius = 0.02;       // m
constexpr double kCubeSpacing = 2.0;   // m from cube to cube, of 1 m
constexpr double kDrop = 0.5;          // m
constexpr double kClearance = 1e-3;    // m between a resting cube and the floor at first
constexpr double kHigh = 100.0;        // m: no body comes near the floor during the measurement

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

ContactScene cubeScene(Role role, std::uint32_t count, bool quick) {
  ContactScene scene;
  scene.name = std::to_string(count) + " cubes " + nameOf(role);
  scene.role = role;
  scene.bodies = cubes(role, count);
  const double halfWidth = 0.5 * kCubeSpacing * std::ceil(std::sqrt(double(count))) + 5.0;
  scene.addRigidBodies = [halfWidth](RigidBodies& rigid) {
    addBox(rigid, {halfWidth, 1, halfWidth}, 0, {0, -1, 0}, 0.5);
  };
  scene.distance = [](const Eigen::Vector3d& x) { return x.y(); };
  setTimes(scene, quick);
  return scene;
}

}  // namespace

// --- a cloth and a lattice ---

std::vector<Triangle> boxSurface(int side) {
  const auto count = static_cast<std::uint32_t>(side);
  const std::uint32_t strides[] = {count * count, count, 1};  // of a point's index along x, y and z
  std::vector<Triangle> triangles;
  for (int axis = 0; axis < 3; ++axis) {
    const std::uint32_t u = strides[(axis + 1) % 3], v = strides[(axis + 2) % 3];
    for (std::uint32_t i = 0; i + 1 < count; ++i)
      for (std::uint32_t j = 0; j + 1 < count; ++j) {
        const std::uint32_t near = i * u + j * v, far = near + (count - 1) * strides[axis];
        triangles.insert(triangles.end(), {{far, far + u, far + u + v}, {far, far + u + v, far + v}});
        triangles.insert(triangles.end(), {{near, near + u + v, near + u}, {near, near + v, near + u + v}});
      }
  }
  return triangles;
}

namespace {

constexpr double kClothWidth = 2.4, kClothRadius = 0.01, kBallRadius = 0.75;  // m
constexpr double kGround = -2.0;                                              // m

/// Adds a ball at the origin, and a floor below for bodies that fall off.
void addBallAndFloor(RigidBodies& rigid) {
  addBox(rigid, {10, 1, 10}, 0, {0, kGround - 1, 0}, 0.5);
  addBody(rigid, std::make_unique<btSphereShape>(static_cast<btScalar>(kBallRadius)), 0, {0, 0, 0}, 1);
}

/// Returns a cloth that falls onto a ball and hangs down from it, above the floor. The ratio of the dampers
/// to critical damping does not depend on the stiffness (N/m).
ContactScene clothScene(bool quick, const char* name, double stiffness) {
  const int side = quick ? 12 : 64;
  BodySetup cloth = bodyOf(clothNetwork(side), 0.6, stiffness, 0.5 * std::sqrt(stiffness / 500.0));
  cloth.settings.scale.setConstant(kClothWidth);
  cloth.settings.position = {0, kBallRadius + 2 * kClothRadius, 0};
  cloth.settings.rotation = Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitY());
  cloth.settings.pointRadius = kClothRadius;
  cloth.drag = 1.0;
  ContactScene scene;
  scene.name = name + std::to_string(side) + " x " + std::to_string(side);
  scene.role = Role::Cloth;
  scene.bodies = {cloth};
  scene.addRigidBodies = addBallAndFloor;
  scene.distance = [](const Eigen::Vector3d& x) { return std::min(x.norm() - kBallRadius, x.y() - kGround); };
  scene.size = kClothWidth;
  scene.withBudgets = true;
  scene.settleTicks = quick ? 60 : 180;
  return scene;
}

/// Returns a cube of 1 m with many points and springs between all neighbours.
ContactScene denseScene(bool quick) {
  const int side = quick ? 4 : 17;  // 4913 points
  const double spacing = 1.0 / (side - 1);
  auto network = std::make_shared<SpringNetwork>(*latticeNetwork(side, side, side, spacing));
  network->surface = boxSurface(side);
  BodySetup body = bodyOf(network, 20.0, 500.0, 1.0);
  body.settings.pointRadius = 0.2 * spacing;
  body.settings.position = {-0.5, *body.settings.pointRadius + 1e-3, -0.5};
  body.drag = 1.0;
  ContactScene scene;
  scene.role = Role::Dense;
  scene.bodies = {body};
  scene.withBudgets = true;
  scene.name = "dense body of " + std::to_string(network->restPoints.size()) + " points";
  scene.addRigidBodies = [](RigidBodies& rigid) { addFloor(rigid, Floor::Box, 0.5); };
  scene.distance = [](const Eigen::Vector3d& x) { return x.y(); };
  scene.settleTicks = 60;
  scene.measuredTicks = quick ? 20 : 40;
  return scene;
}

// --- a pile in a bin ---

constexpr double kSize = 0.5;         // m, of a body; boxes are half as high
constexpr double kPileSpacing = 0.9;  // m: at any rotation, neighbours do not touch at first
constexpr int kColumns = 5;           // along x and z
constexpr double kHalf = 0.5 * kColumns * kPileSpacing;  // m, inside of the bin
constexpr double kThick = 0.5;                           // m, half thickness of its walls
constexpr double kTall = 8.0;                            // m, half height: no body can jump out

/// Returns a network whose springs are equally stiff, which btDeformable requires.
SharedNetwork braced(const TriangleMesh& mesh, double scale) {
  TriangleMesh sized = mesh;
  for (auto& p : sized.positions) p *= scale;
  NetworkSettings settings;
  settings.braceWeight = 1.0;
  return valueOf(buildNetwork(sized, settings));
}

/// Returns cubes, flat boxes, and balls of 12 and of 42 points.
std::vector<BodySetup> kinds() {
  std::vector<BodySetup> kinds;
  const auto add = [&](SharedNetwork network, double mass, const Eigen::Vector3d& scale) {
    kinds.push_back(bodyOf(std::move(network), mass, 1000.0, 2.0));
    kinds.back().settings.scale = scale;
    kinds.back().settings.pointRadius = 0.02;
    kinds.back().drag = 1.0;
  };
  add(closedCubeNetwork(), 0.4, Eigen::Vector3d::Constant(kSize));
  add(braced(small_meshes::icosphere(0), 0.5 * kSize), 0.3, Eigen::Vector3d::Ones());
  add(closedCubeNetwork(), 0.3, {kSize, 0.5 * kSize, kSize});
  add(braced(small_meshes::icosphere(1), 0.5 * kSize), 0.6, Eigen::Vector3d::Ones());
  return kinds;
}

std::vector<BodySetup> bodiesOf(int count) {
  Dice dice(7);
  std::vector<BodySetup> allKinds = kinds(), bodies;
  for (int i = 0; i < count; ++i) {
    BodySetup body = allKinds[static_cast<std::size_t>(i) % allKinds.size()];
    const Eigen::Vector3d cell(i % kColumns, i / (kColumns * kColumns), i / kColumns % kColumns);
    body.settings.position =
        kPileSpacing * (cell + Eigen::Vector3d::Constant(0.5)) - Eigen::Vector3d(kHalf, 0, kHalf);
    body.settings.rotation = dice.rotation();
    bodies.push_back(body);
  }
  return bodies;
}

void addBin(RigidBodies& rigid) {
  addBox(rigid, {kHalf + 2 * kThick, 1, kHalf + 2 * kThick}, 0, {0, -1, 0}, 0.5);
  for (const double side : {-1.0, 1.0}) {
    const double at = side * (kHalf + kThick);
    addBox(rigid, {kThick, kTall, kHalf + 2 * kThick}, 0, {at, kTall, 0}, 0.5);
    addBox(rigid, {kHalf, kTall, kThick}, 0, {0, kTall, at}, 0.5);
  }
}

/// Returns the distance from floor and walls (m), for points in the bin or slightly inside the walls.
double distance(const Eigen::Vector3d& x) {
  return std::min({x.y(), kHalf - std::abs(x.x()), kHalf - std::abs(x.z())});
}

ContactScene pileScene(bool quick) {
  const int count = quick ? 8 : 200;
  ContactScene scene;
  scene.name = "pile of " + std::to_string(count);
  scene.role = Role::Pile;
  scene.bodies = bodiesOf(count);
  scene.addRigidBodies = addBin;
  scene.distance = distance;
  scene.size = kSize;
  scene.settleTicks = quick ? 60 : 240;
  return scene;
}

/// The same pile while its bodies hit each other.
ContactScene landingPileScene(bool quick) {
  ContactScene scene = pileScene(quick);
  scene.name = "landing " + scene.name;
  scene.settleTicks = quick ? 20 : 40;
  scene.measuredTicks = quick ? 20 : 80;
  return scene;
}

}  // namespace

std::vector<ContactScene> allContactScenes(bool quick) {
  const std::vector<std::uint32_t> few = {2, 4, 8}, many = {64, 512, 4096};
  std::vector<ContactScene> scenes;
  for (const Role role : {Role::Airborne, Role::Landing, Role::Rest, Role::Asleep})
    for (const std::uint32_t count : quick ? few : many) scenes.push_back(cubeScene(role, count, quick));
  scenes.push_back(cubeScene(Role::Rest, quick ? 6 : 2560, quick));  // in real time
  scenes.back().withOthers = false;
  scenes.push_back(clothScene(quick, "cloth of ", 500.0));
  scenes.push_back(clothScene(quick, "soft cloth of ", 5.0));
  scenes.push_back(clothScene(quick, "stiff cloth of ", 5e4));
  scenes.push_back(denseScene(quick));
  scenes.push_back(landingPileScene(quick));
  scenes.push_back(pileScene(quick));
  return scenes;
}

}  // namespace limber::bench
