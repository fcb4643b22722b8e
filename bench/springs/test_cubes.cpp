// SPDX-License-Identifier: Zlib
#include "springs/test_cubes.h"

#include "solver/springs.h"

#include <Eigen/Geometry>

namespace limber::bench {
namespace {

constexpr double kStiffness = 1000.0, kPointMass = 0.125;

SpringNetwork cubeOfAllPairs() {
  SpringNetwork network;
  for (std::uint32_t i = 0; i < 8; ++i) {
    network.restPoints.emplace_back(i & 1u ? 0.5 : -0.5, i & 2u ? 0.5 : -0.5, i & 4u ? 0.5 : -0.5);
    network.massFractions.push_back(kPointMass);
    for (std::uint32_t j = 0; j < i; ++j) network.springs.push_back({j, i, SpringKind::Structural, 1.0});
  }
  return network;
}

void addFloor(TestCube& cube) {
  for (std::uint32_t i = 0; i < 8; ++i) {
    cube.state.velocity.col(i).setZero();
    if (cube.state.position(1, i) > 0.0) continue;
    PlaneContact row;
    row.point = i;
    row.friction = 0.5;
    row.touch = cube.state.position.col(i);
    cube.contacts.push_back(row);
  }
}

void fill(TestCube& cube, const SpringNetwork& network, int which, double damping, bool resting) {
  SoftBodySettings settings;
  settings.extensionStiffness = settings.compressionStiffness = kStiffness;
  settings.damping = damping;
  if (!cube.springs.size()) cube.springs = makeSprings(network, settings);
  cube.state.resize(8);
  for (std::uint32_t i = 0; i < 8; ++i) {
    const Eigen::Vector3d x = network.restPoints[i];
    cube.state.position.col(i) = resting ? x : Eigen::Vector3d((1.0 + 0.01 * which) * x);
    cube.state.velocity.col(i) = Eigen::Vector3d(1.0, 2.0, 0.5).cross(x);
    cube.state.acceleration.col(i) = Eigen::Vector3d(0.0, resting ? -9.81 : 0.0, 0.0);
    cube.state.inverseMass.col(i).setConstant(1.0 / kPointMass);
  }
  if (resting) addFloor(cube);
  cube.group.bodies.push_back({&cube.state, &cube.springs, &cube.contacts});
  cube.group.links.points.push_back(&cube.state);
}

}  // namespace

std::deque<TestCube> makeCubes(int count, double damping, bool resting) {
  const SpringNetwork network = cubeOfAllPairs();
  std::deque<TestCube> cubes(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) {
    TestCube& cube = cubes[static_cast<std::size_t>(i)];
    cube.springs = cubes[0].springs;  // equal bodies share their constants
    fill(cube, network, i, damping, resting);
  }
  return cubes;
}

}  // namespace limber::bench
