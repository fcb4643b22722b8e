// SPDX-License-Identifier: Zlib
#include "accuracy/bodies.h"
#include "contact/contact_scene.h"
#include "stability/case_parts.h"
#include "support/small_meshes.h"

#include <limber/network_builder.h>

#include <algorithm>
#include <array>
#include <stdexcept>

namespace limber::bench {
namespace {

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
  Result<SharedNetwork> network = buildNetwork(sized, settings);
  if (!network) throw std::runtime_error(network.error());
  return *network;
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

void addBin(RigidBodies& rigid, btDiscreteDynamicsWorld& world) {
  addBox(rigid, world, {kHalf + 2 * kThick, 1, kHalf + 2 * kThick}, 0, {0, -1, 0}, 0.5);
  for (const double side : {-1.0, 1.0}) {
    const double at = side * (kHalf + kThick);
    addBox(rigid, world, {kThick, kTall, kHalf + 2 * kThick}, 0, {at, kTall, 0}, 0.5);
    addBox(rigid, world, {kHalf, kTall, kThick}, 0, {0, kTall, at}, 0.5);
  }
}

/// Returns the distance from floor and walls (m), for points in the bin or slightly inside the walls.
double distance(const Eigen::Vector3d& x) {
  return std::min({x.y(), kHalf - std::abs(x.x()), kHalf - std::abs(x.z())});
}

}  // namespace

void addPile(std::vector<ContactScene>& scenes, bool quick) {
  const int count = quick ? 8 : 200;
  ContactScene scene;
  scene.name = "pile of " + std::to_string(count);
  scene.role = Role::Pile;
  scene.bodies = bodiesOf(count);
  scene.addRigidBodies = addBin;
  scene.distance = distance;
  scene.size = kSize;
  scene.settleTicks = quick ? 60 : 240;
  scenes.push_back(std::move(scene));
}

}  // namespace limber::bench
