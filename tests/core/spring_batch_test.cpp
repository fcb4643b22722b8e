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

/// A cloth with two equal springs between some points, and without the springs of one point.
SharedNetwork mendedCloth() {
  auto network = std::make_shared<SpringNetwork>(*test::clothNetwork(14, 17));
  const auto touchesHole = [](const NetworkSpring& s) { return s.a == 40 || s.b == 40; };
  auto& springs = network->springs;
  springs.erase(std::remove_if(springs.begin(), springs.end(), touchesHole), springs.end());
  for (std::size_t i = 0; i < 60; i += 7) springs.push_back(springs[i]);
  std::swap(springs[3].a, springs[3].b);
  return network;
}

/// A cloth of n x n fields whose points have other numbers in each row, so that it is not regular.
SharedNetwork shuffledCloth(std::uint32_t n) {
  const SharedNetwork regular = test::clothNetwork(n, n);
  auto network = std::make_shared<SpringNetwork>(*regular);
  const std::uint32_t side = n + 1;
  const auto numberOf = [&](std::uint32_t i) {
    const std::uint32_t row = i / side;
    return row * side + (i + 5 * row * row) % side;
  };
  for (std::uint32_t i = 0; i < side * side; ++i) network->restPoints[numberOf(i)] = regular->restPoints[i];
  for (NetworkSpring& spring : network->springs) spring.a = numberOf(spring.a), spring.b = numberOf(spring.b);
  return network;
}

/// They have strips of several lengths: with points missing in the last one, or in all slots of it.
std::vector<SharedNetwork> regularNetworks() {
  return {test::chainNetwork(30),
          test::clothNetwork(9, 11),
          test::clothNetwork(15, 15),
          test::clothNetwork(40, 8),
          mendedCloth(),
          test::tetrahedralBlockNetwork(3, 3, 20)};
}

std::vector<SharedNetwork> networks() {
  std::vector<SharedNetwork> all = regularNetworks();
  for (const SharedNetwork& network :
       {test::pairNetwork(), test::chainNetwork(3), test::cubeNetwork(), test::fullCubeNetwork(),
        test::clothNetwork(7, 5), test::closedCubeNetwork(), test::tetrahedronNetwork(),
        test::tetrahedralCubeNetwork()})
    all.push_back(network);
  return all;
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

/// The same with springs that bear no compression.
struct SlackBody : DeformedBody {
  SlackBody(const SharedNetwork& network, double damping) : DeformedBody(network, damping) {
    settings.compressionStiffness = 0.0;
    springs = makeSprings(*network, settings);
  }
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

/// A falling body whose points hit a ball, a capsule, a box and planes, some of which bounce. Two points
/// touch two surfaces.
struct HittingBody : SteppedTestBody {
  HittingBody(const SharedNetwork& network, double damping) : SteppedTestBody(network, 300.0, damping) {
    disturb();
    for (Eigen::Index i = 0; i < state.velocity.cols(); ++i) state.velocity(1, i) -= 3.0;
    const double low = state.position.row(1).minCoeff();
    held.pieces.resize(3);
    for (HeldPiece& piece : held.pieces) {
      piece.kind = HeldPiece::Kind::Capsule;
      piece.margin = 0.5;
      piece.center = {0.1, low - 0.52, 0.2};
    }
    held.pieces[1].size = {0.0, 0.3, 0.0};
    held.pieces[1].axes = Eigen::Quaterniond(0.9, 0.1, 0.3, 0.2).normalized().toRotationMatrix();
    held.pieces[2].kind = HeldPiece::Kind::Box;
    held.pieces[2].size.setConstant(0.5);
    const auto count = static_cast<std::uint32_t>(state.position.cols());
    around.resize(count);
    for (std::uint32_t i = 0; i < count; ++i) addRows(i, low - 0.02);
    contacts = &rows;
  }
  HittingBody(const HittingBody&) = delete;
  HittingBody& operator=(const HittingBody&) = delete;

  void addRows(std::uint32_t point, double floor) {
    PlaneContact row;
    row.point = point;
    row.friction = 0.4;
    row.recoverySpeed = 1.0;
    row.restitution = point % 7 == 6 ? 0.5 : 0.0;
    row.touch = state.position.col(point);
    row.touch.y() = floor;
    if (point % 5 != 4) {
      around[point].all = &held;
      around[point].begin = point % 3, around[point].end = around[point].begin + 1;
      around[point].radius = point % 11 == 10 ? 0.01 : 0.02;
      row.around = &around[point];
      row.away = true;
      row.surfaceVelocity = {0.0, 0.0, point % 2 ? 0.1 : 0.0};
    }
    rows.push_back(row);
    if (point % 9 != 8) return;
    rows.push_back(rows.back());
    rows.back().around = nullptr;
    rows.back().normal = Eigen::Vector3d(0.3, 1.0, 0.0).normalized();
  }

  HeldSurroundings held;
  std::vector<HeldNeighbourhood> around;
  std::vector<PlaneContact> rows;
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
    for (const double damping : {0.0, 0.2}) {
      compareSteps<DeformedBody>(network, damping);
      compareSteps<SlackBody>(network, damping);
    }
}

TEST(Quads, giveTheBitsOfSpringBySpringToLinkedBodies) {
  if (!canStepSpringBatches()) GTEST_SKIP() << "this machine has neither AVX2 nor NEON";
  for (const SharedNetwork& network : networks())
    for (const double damping : {0.0, 0.2}) compareSteps<LinkedBody>(network, damping);
}

/// Rows that the kernel solves four at a time must end as the others do.
TEST(Quads, giveTheBitsOfSingleContacts) {
  if (!canStepSpringBatches()) GTEST_SKIP() << "this machine has neither AVX2 nor NEON";
  for (const SharedNetwork& network : networks()) {
    SCOPED_TRACE(testing::Message() << network->restPoints.size() << " points");
    HittingBody single(network, 0.2), four(network, 0.2);
    SpringBatchArrays springBatches;
    four.stepped().springBatches = &springBatches;
    single.stepped();
    double pressed = 0.0;
    for (int tick = 0; tick < 30; ++tick) {
      stepVerlet(single.group, 1.0 / 60, 8);
      stepVerlet(four.group, 1.0 / 60, 8);
      ASSERT_TRUE((single.state.position.array() == four.state.position.array()).all()) << tick;
      ASSERT_TRUE((single.state.velocity.array() == four.state.velocity.array()).all()) << tick;
      for (std::size_t i = 0; i < single.rows.size(); ++i) {
        const PlaneContact &a = single.rows[i], &b = four.rows[i];
        ASSERT_TRUE(a.normal == b.normal && a.touch == b.touch) << tick << " row " << i;
        ASSERT_TRUE(a.impulse.sum == b.impulse.sum && a.impulse.pressing == b.impulse.pressing);
        ASSERT_TRUE(a.away == b.away && a.mass == b.mass && a.touching == b.touching) << tick << " row " << i;
        pressed += b.impulse.along;
      }
    }
    if (single.rows.size() > 20) {
      EXPECT_GT(pressed, 0.0);
    }
  }
}

// --- strips ------------------------------------------------------------------------------------------------

/// Checks that each batch has springs between its two slots, one for each strip at most.
void checkBatches(const SpringNetwork& network, const Division& division) {
  const Strips& strips = division.strips;
  ASSERT_EQ(strips.places.size(), network.springs.size());
  for (std::size_t i = 0; i < strips.places.size(); ++i) {
    ASSERT_TRUE(i == 0 || strips.places[i - 1] < strips.places[i]);
    const NetworkSpring& spring = network.springs[division.order[i]];
    const std::uint32_t low = std::min(spring.a, spring.b), high = std::max(spring.a, spring.b);
    const Strips::Batch& batch = strips.batches[strips.places[i] / Strips::kCount];
    const std::uint32_t strip = strips.places[i] % Strips::kCount;
    ASSERT_NE(batch.a, batch.b);
    ASSERT_LE(batch.shift, 1u);
    ASSERT_EQ(low, strip * strips.length + batch.a);
    ASSERT_EQ(high, (strip + batch.shift) * strips.length + batch.b);
  }
}

TEST(Strips, joinTheSameSlots) {
  for (const SharedNetwork& network : regularNetworks()) {
    SCOPED_TRACE(testing::Message() << network->restPoints.size() << " points");
    const Division division = divideSprings(*network);
    ASSERT_GT(division.strips.length, 0u);
    EXPECT_GE(Strips::kCount * division.strips.length, network->restPoints.size());
    EXPECT_GE(double(network->springs.size()) / double(division.strips.batches.size()), 2.8);
    checkBatches(*network, division);
  }
}

TEST(Strips, areOfRegularNetworksOnly) {
  for (const SharedNetwork& network :
       {shuffledCloth(20), test::pairNetwork(), test::fullCubeNetwork(), test::clothNetwork(7, 5)})
    EXPECT_EQ(divideSprings(*network).strips.length, 0u) << network->restPoints.size();
  EXPECT_EQ(divideSprings(SpringNetwork()).strips.length, 0u);
}

// --- the order ---------------------------------------------------------------------------------------------

TEST(SpringOrder, hasEverySpringOnceAndMostFoursApart) {
  for (const SharedNetwork& network : networks()) {
    const Division division = divideSprings(*network);
    std::vector<std::uint32_t> order = division.order;
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
    if (order.size() > 30 && division.strips.length == 0) {
      EXPECT_GE(disjoint, fours * 9 / 10) << order.size();
    }
    std::sort(order.begin(), order.end());
    for (std::uint32_t i = 0; i < order.size(); ++i) ASSERT_EQ(order[i], i);
  }
}

/// Batches that share no point with the ones before them need not wait for these. At the end of each range of
/// a divided body few springs are left to choose from: some 100 springs at each of four ends.
TEST(SpringOrder, putsSpringsThatShareAPointFarApart) {
  const SharedNetwork network = shuffledCloth(40);
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
