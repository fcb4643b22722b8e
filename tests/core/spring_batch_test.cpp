// SPDX-License-Identifier: Zlib
// A body stepped with four springs at a time must equal the same body stepped with single springs, bit for
// bit.
#include "solver/simd_steps.h"
#include "solver/springs.h"
#include "support/networks.h"
#include "support/stepped_body.h"

#include <limber/network_builder.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace limber {
namespace {

using test::SteppedTestBody;

std::vector<SharedNetwork> networks() {
  ClothSettings cloth;
  cloth.columns = 7;
  cloth.rows = 5;
  return {test::pairNetwork(),       test::chainNetwork(3),      test::chainNetwork(30),
          test::cubeNetwork(),       test::fullCubeNetwork(),    *buildCloth(cloth),
          test::closedCubeNetwork(), test::tetrahedronNetwork(), test::tetrahedralCubeNetwork()};
}

/// A deformed, moving body with one static point and one plane contact.
struct DeformedBody : SteppedTestBody {
  DeformedBody(const SharedNetwork& network, double damping) : SteppedTestBody(network, 300.0, damping) {
    disturb();
    PlaneContact row;
    row.point = 1;
    row.friction = 0.3;
    row.touch = state.position.col(1);
    rows.push_back(row);
    contacts = &rows;
  }
  std::vector<PlaneContact> rows;
};

/// The same with links: one-sided springs to a moving place in the world, a spring to a rigid body and an
/// anchor on it.
struct LinkedBody : DeformedBody {
  LinkedBody(const SharedNetwork& network, double damping) : DeformedBody(network, damping) {
    RigidState rigid;
    rigid.position = {0.3, 1.0, 0.2};
    rigid.inverseMass.setConstant(0.5);
    rigid.inverseInertiaLocal.setConstant(3.0);
    rigid.angularVelocity = {0.5, 1.0, -2.0};
    group.links.rigids.push_back(rigid);
    const LinkEnd pivot{LinkEnd::Kind::Rigid, 0, 0, {0.1, 0.2, 0.0}};
    const LinkEnd place{LinkEnd::Kind::World, 0, 0, {0.5, 0.5, 0.0}, {1.0, 0.0, 0.5}};
    const auto last = static_cast<std::uint32_t>(state.position.cols() - 1);
    group.links.springs = {{point(1), place, 0.3, 200.0, 0.0, 1.0},
                           {point(last), place, 2.0, 0.0, 200.0, 1.0},
                           {pivot, point(last), 0.5, 100.0, 100.0, 0.5}};
    group.links.anchors.push_back({point(1), pivot});
  }
  static LinkEnd point(std::uint32_t i) { return {LinkEnd::Kind::Point, 0, i, Eigen::Vector3d::Zero()}; }
};

/// Steps two equal bodies, one of them with single springs, and compares them.
template <class Body>
void compareSteps(const SharedNetwork& network, double damping) {
  SCOPED_TRACE(testing::Message() << network->springs.size() << " springs, damping " << damping);
  Body single(network, damping), four(network, damping);
  SpringBatchArrays springBatches;
  four.stepped().springBatches = &springBatches;
  for (int tick = 0; tick < 20; ++tick) {
    const int substeps = tick < 10 ? 6 : 9;
    single.stepped();
    stepVerlet(single.group, 1.0 / 60, substeps);
    stepVerlet(four.group, 1.0 / 60, substeps);
    ASSERT_TRUE((single.state.position.array() == four.state.position.array()).all()) << tick;
    ASSERT_TRUE((single.state.velocity.array() == four.state.velocity.array()).all()) << tick;
    ASSERT_EQ(single.group.bodies[0].errorRate, four.group.bodies[0].errorRate) << tick;
  }
  EXPECT_TRUE(four.state.position.allFinite());
}

TEST(Quads, giveTheBitsOfSpringBySpring) {
  if (!canStepSpringBatches()) GTEST_SKIP() << "this machine has neither AVX2 nor NEON";
  for (const SharedNetwork& network : networks())
    for (const double damping : {0.0, 0.2}) compareSteps<DeformedBody>(network, damping);
}

TEST(Quads, giveTheBitsOfSpringBySpringToLinkedBodies) {
  if (!canStepSpringBatches()) GTEST_SKIP() << "this machine has neither AVX2 nor NEON";
  for (const SharedNetwork& network : networks())
    for (const double damping : {0.0, 0.2}) compareSteps<LinkedBody>(network, damping);
}

TEST(SpringOrder, hasEverySpringOnceAndMostFoursApart) {
  for (const SharedNetwork& network : networks()) {
    std::vector<std::uint32_t> order = divideSprings(*network).order;
    const auto sharePoint = [&](std::uint32_t i, std::uint32_t j) {
      const NetworkSpring &s = network->springs[i], &t = network->springs[j];
      return s.a == t.a || s.a == t.b || s.b == t.a || s.b == t.b;
    };
    std::size_t disjoint = 0, fours = order.size() / 4;
    for (std::size_t g = 0; g < fours; ++g) {
      bool allDisjoint = true;
      for (std::size_t i = 0; i < 4; ++i)
        for (std::size_t j = 0; j < i; ++j)
          allDisjoint = allDisjoint && !sharePoint(order[4 * g + i], order[4 * g + j]);
      disjoint += allDisjoint;
    }
    if (order.size() > 30) {
      EXPECT_GE(disjoint, fours * 9 / 10) << order.size();
    }
    std::sort(order.begin(), order.end());
    for (std::uint32_t i = 0; i < order.size(); ++i) ASSERT_EQ(order[i], i);
  }
}

/// Batches that share no point with the ones before them need not wait for these. At the end of each range of
/// a divided body few springs are left to choose from: some 100 springs at each of four ends.
TEST(SpringOrder, putsSpringsThatShareAPointFarApart) {
  ClothSettings cloth;
  cloth.columns = cloth.rows = 40;
  const SharedNetwork network = *buildCloth(cloth);
  std::vector<std::size_t> last(network->restPoints.size(), 0);
  std::size_t place = 0, near = 0;
  for (const std::uint32_t i : divideSprings(*network).order) {
    const NetworkSpring& s = network->springs[i];
    ++place;
    for (const std::uint32_t point : {s.a, s.b}) {
      near += last[point] > 0 && place - last[point] < 16;
      last[point] = place;
    }
  }
  EXPECT_LE(near, network->springs.size() / 25);
}

}  // namespace
}  // namespace limber
