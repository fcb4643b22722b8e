// SPDX-License-Identifier: Zlib
#include "springs/test_cubes.h"

#include "solver/springs.h"

#include <Eigen/Geometry>

namespace limber::bench {
namespace {

constexpr double kStiffness = 1000.0, kPointMass = 0.125, kSubstep = 1.0 / 1200;

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
  cube.springs = makeSprings(network, settings);
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

/// The number at [i * lanes + lane] of the floats in the array.
void setFloat(AlignedNumbers& array, std::size_t at, double value) {
  reinterpret_cast<float*>(array.data())[at] = static_cast<float>(value);
}

void toLane(const Eigen::Ref<const Eigen::VectorXd>& from, AlignedNumbers& to, std::size_t lane,
            std::size_t lanes) {
  reserveNumbers(to, static_cast<std::size_t>(from.size()) * lanes);
  for (Eigen::Index i = 0; i < from.size(); ++i)
    setFloat(to, static_cast<std::size_t>(i) * lanes + lane, from[i]);
}

Eigen::Map<const Eigen::VectorXd> flat(const Points& points) { return {points.data(), points.size()}; }

Eigen::Map<const Eigen::VectorXd> flat(const std::vector<double>& values) {
  return {values.data(), static_cast<Eigen::Index>(values.size())};
}

}  // namespace

std::deque<TestCube> makeCubes(int count, double damping, bool resting) {
  const SpringNetwork network = cubeOfAllPairs();
  std::deque<TestCube> cubes(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) fill(cubes[static_cast<std::size_t>(i)], network, i, damping, resting);
  return cubes;
}

FloatLanes makeFloats(int lanes, double damping) {
  FloatLanes floats;
  std::deque<TestCube> cubes = makeCubes(lanes, damping, false);
  const auto count = static_cast<std::size_t>(lanes);
  for (std::size_t l = 0; l < count; ++l) {
    PointState& state = cubes[l].state;
    SpringArrays& springs = cubes[l].springs;
    prepareDampers(springs, state.inverseMass, kSubstep);
    springs.direction.setZero(3, static_cast<Eigen::Index>(springs.size()));
    toLane(flat(state.position), floats.position, l, count);
    toLane(flat(state.velocity), floats.velocity, l, count);
    toLane(flat(state.force), floats.force, l, count);
    toLane(flat(state.earlierForce), floats.earlierForce, l, count);
    toLane(flat(state.acceleration), floats.acceleration, l, count);
    toLane(flat(state.inverseMass), floats.inverseMass, l, count);
    toLane(flat(springs->restLength), floats.restLength, l, count);
    toLane(flat(springs->extensionStiffness), floats.stiffness, l, count);
    toLane(flat(springs.dampHalf), floats.dampHalf, l, count);
    toLane(flat(springs.dampFull), floats.dampFull, l, count);
    toLane(flat(springs.direction), floats.direction, l, count);
  }
  floats.points = 8;
  floats.a.assign(cubes[0].springs->a.begin(), cubes[0].springs->a.end());
  floats.b.assign(cubes[0].springs->b.begin(), cubes[0].springs->b.end());
  floats.springs = static_cast<unsigned>(floats.a.size());
  floats.damped = damping > 0.0;
  return floats;
}

LaneBlock makeBlock(std::deque<TestCube>& cubes) {
  LaneBlock block;
  for (TestCube& cube : cubes) {
    block.lanes.emplace_back();
    block.lanes.back().body = cube.group.bodies[0];
  }
  return block;
}

}  // namespace limber::bench
