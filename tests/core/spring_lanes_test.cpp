// SPDX-License-Identifier: Zlib
// Bodies stepped side by side in lanes must equal the same bodies stepped one by one, bit for bit, with every
// instruction set.
#include "solver/simd_steps.h"
#include "solver/verlet_step.h"
#include "support/networks.h"

#include <gtest/gtest.h>

#include <cmath>
#include <deque>

namespace limber {
namespace {

struct LaneBody {
  PointState state;
  SpringArrays springs;
  VolumeArrays volumes;
  TetrahedronVolumes tetrahedra;
  std::vector<PlaneContact> contacts;
  SolverIsland island;

  SolverBody stepped() {
    return {&state, &springs, &contacts, volumes.empty() ? nullptr : &volumes,
            tetrahedra.empty() ? nullptr : &tetrahedra};
  }
};

/// Fills in a cube. Cubes of different `index` differ in stiffness, damping, position, velocity, contacts,
/// pressure and static points.
void fill(LaneBody& body, const SharedNetwork& network, int index, double damping) {
  SoftBodySettings settings;
  settings.extensionStiffness = 500.0 + 100.0 * index;
  settings.compressionStiffness = index == 2 ? 0.0 : 700.0;
  settings.damping = damping * (1 + index);
  settings.pressure = network->surface.empty() ? 0.0 : 10.0 * index;
  body.springs = makeSprings(*network, settings);
  body.volumes = makeVolumes(*network, settings);
  body.tetrahedra = makeTetrahedronVolumes(*network, settings);
  body.state.resize(8);
  for (std::uint32_t i = 0; i < 8; ++i) {
    const Eigen::Vector3d x = network->restPoints[i];
    body.state.position.col(i) = (1.0 + 0.05 * index) * x + Eigen::Vector3d(3.0 * index, 0.02 * i, 0.0);
    body.state.velocity.col(i) = Eigen::Vector3d(index, -1.0, 0.5).cross(x);
    body.state.acceleration.col(i) = Eigen::Vector3d(0.0, -9.81, 0.0);
    body.state.inverseMass.col(i).setConstant(index == 4 && i == 0 ? 0.0 : 8.0);
  }
  if (index == 5) body.state.position.col(1) = body.state.position.col(0);  // coincident ends
  for (std::uint32_t i = 0; i < 8 && index % 2 == 1; i += 3) {
    PlaneContact row;
    row.point = i;
    row.friction = 0.4;
    row.touch = Eigen::Vector3d(0.0, -0.4 - 0.05 * i, 0.0);
    row.surfaceVelocity = Eigen::Vector3d(0.1, 0.3, 0.0);
    body.contacts.push_back(row);
  }
  body.island.bodies.push_back(body.stepped());
  body.island.links.points.push_back(&body.state);
}

std::deque<LaneBody> makeBodies(const SharedNetwork& network, int count, double damping) {
  std::deque<LaneBody> bodies(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) fill(bodies[static_cast<std::size_t>(i)], network, i, damping);
  return bodies;
}

bool sameBits(const Points& a, const Points& b) { return (a.array() == b.array()).all(); }

class Lanes : public testing::TestWithParam<InstructionSet> {};

TEST_P(Lanes, giveTheBitsOfSingleBodies) {
  const InstructionSet set = GetParam();
  if (!isAvailable(set)) GTEST_SKIP() << "this machine has no " << nameOf(set);
  const std::vector<std::pair<SharedNetwork, double>> kinds = {{test::cubeNetwork(), 0.0},
                                                               {test::cubeNetwork(), 0.7},
                                                               {test::closedCubeNetwork(), 0.7},
                                                               {test::tetrahedralCubeNetwork(), 0.7}};
  for (const auto& [network, damping] : kinds)
    for (int count = 1; count <= laneCount(set); ++count) {
      std::deque<LaneBody> single = makeBodies(network, count, damping);
      std::deque<LaneBody> laned = makeBodies(network, count, damping);
      LaneBlock block;
      LaneScratch scratch;
      for (LaneBody& body : laned) {
        block.lanes.emplace_back();
        block.lanes.back().body = body.stepped();
      }
      for (int tick = 0; tick < 20; ++tick) {
        for (LaneBody& body : single) stepVerlet(body.island, 1.0 / 60.0, 7);
        stepLanes(block, scratch, 1.0 / 60.0, 7, set);
      }
      for (std::size_t i = 0; i < single.size(); ++i) {
        SCOPED_TRACE(testing::Message() << "damping " << damping << ", body " << i << " of " << count);
        EXPECT_TRUE(sameBits(single[i].state.position, laned[i].state.position));
        EXPECT_TRUE(sameBits(single[i].state.velocity, laned[i].state.velocity));
        EXPECT_EQ(single[i].island.bodies[0].errorRate, block.lanes[i].body.errorRate);
        EXPECT_TRUE(single[i].state.position.allFinite());
        for (std::size_t c = 0; c < single[i].contacts.size(); ++c)
          EXPECT_EQ(single[i].contacts[c].impulse.sum, laned[i].contacts[c].impulse.sum);
      }
    }
}

INSTANTIATE_TEST_SUITE_P(Sets, Lanes,
                         testing::Values(InstructionSet::Sse2, InstructionSet::Avx2, InstructionSet::Avx512),
                         [](const auto& i) {
                           return std::string(i.param == InstructionSet::Avx512 ? "AVX512" : nameOf(i.param));
                         });

TEST(Lanes, takeUpNewSpringsWhenTheyChange) {
  const InstructionSet set = bestInstructionSet();
  if (set == InstructionSet::Scalar) GTEST_SKIP() << "this processor has no lanes";
  std::deque<LaneBody> single = makeBodies(test::cubeNetwork(), 2, 0.5),
                       laned = makeBodies(test::cubeNetwork(), 2, 0.5);
  LaneBlock block;
  LaneScratch scratch;
  for (LaneBody& body : laned) {
    block.lanes.emplace_back();
    block.lanes.back().body = body.stepped();
  }
  for (const int substeps : {4, 9, 4}) {  // the damping factors depend on the number of substeps
    for (LaneBody& body : single) stepVerlet(body.island, 1.0 / 60.0, substeps);
    stepLanes(block, scratch, 1.0 / 60.0, substeps, set);
    for (std::size_t i = 0; i < 2; ++i)
      EXPECT_TRUE(sameBits(single[i].state.velocity, laned[i].state.velocity)) << substeps;
  }
}

}  // namespace
}  // namespace limber
