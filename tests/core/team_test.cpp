// SPDX-License-Identifier: Zlib
// Threads that step one body together: the team, the division of springs and tetrahedra, and equal bits.
#include "solver/team.h"
#include "solver/simd_steps.h"
#include "solver/springs.h"
#include "support/networks.h"
#include "support/stepped_body.h"

#include <limber/network_builder.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <set>
#include <thread>
#include <vector>

namespace limber {
namespace {

/// Runs lead(team) on this thread, with `helpers` other threads in the team.
template <class Lead>
void leadTeam(unsigned helpers, Lead lead) {
  Team team;
  std::atomic<bool> led{false};
  std::vector<std::thread> threads;
  for (unsigned i = 0; i < helpers; ++i)
    threads.emplace_back([&] {
      while (!led) std::this_thread::yield();
      team.join([] { ADD_FAILURE() << "a second leader"; });
    });
  team.join([&] {
    led = true;
    lead(team);
  });
  for (std::thread& thread : threads) thread.join();
}

// --- the team ----------------------------------------------------------------------------------------------

TEST(Team, runsEachTaskOnce) {
  for (const unsigned helpers : {0u, 1u, 2u, 7u})
    leadTeam(helpers, [&](Team& team) {
      std::vector<int> calls(100);
      for (std::uint32_t round = 0; round < 3000; ++round) {
        const std::uint32_t count = round % 100;
        team.forEach(count, [&](std::uint32_t i) { ++calls[i]; });
      }
      for (int i = 0; i < 100; ++i) ASSERT_EQ(calls[static_cast<std::size_t>(i)], 30 * (99 - i)) << i;
    });
}

/// The tasks of a loop see what those of the loop before have written.
TEST(Team, loopsFollowOneAnother) {
  leadTeam(3, [&](Team& team) {
    std::vector<std::uint64_t> now(16, 1), next(16);
    for (int round = 0; round < 2000; ++round) {
      team.forEach(16, [&](std::uint32_t i) { next[i] = 3 * now[(i + 1) % 16] + now[(i + 5) % 16]; });
      team.forEach(16, [&](std::uint32_t i) { now[i] = next[i] >> 1; });
    }
    std::vector<std::uint64_t> alone(16, 1), after(16);
    for (int round = 0; round < 2000; ++round) {
      for (std::size_t i = 0; i < 16; ++i) after[i] = 3 * alone[(i + 1) % 16] + alone[(i + 5) % 16];
      for (std::size_t i = 0; i < 16; ++i) alone[i] = after[i] >> 1;
    }
    EXPECT_EQ(now, alone);
  });
}

TEST(Team, oneThreadMayJoinSeveralTimes) {
  Team team;
  int leads = 0, tasks = 0;
  for (int i = 0; i < 5; ++i)
    team.join([&] {
      ++leads;
      team.forEach(10, [&](std::uint32_t) { ++tasks; });
    });
  EXPECT_EQ(leads, 1);
  EXPECT_EQ(tasks, 10);
}

TEST(Team, othersDoTheWorkOfAThreadThatDoesNotCome) {
  Team team;
  std::atomic<int> tasks{0};
  std::thread late;
  team.join([&] {
    // joins, and is then kept busy by a task, while the leader goes on alone with a loop of its own
    late = std::thread([&] { team.join([] {}); });
    for (int round = 0; round < 2000; ++round) team.forEach(5, [&](std::uint32_t) { ++tasks; });
  });
  late.join();
  EXPECT_EQ(tasks, 10000);
}

// --- the division ------------------------------------------------------------------------------------------

SharedNetwork largeCloth() {
  ClothSettings cloth;
  cloth.columns = cloth.rows = 40;
  return *buildCloth(cloth);
}

/// 1 089 points, 6 008 springs, 4 608 tetrahedra.
SharedNetwork largeBlock() { return test::tetrahedralBlockNetwork(8, 4, 24); }

bool beginsABatch(const Division& division, std::uint32_t i) {
  const std::vector<std::uint32_t>& places = division.strips.places;
  return places.empty() ? i % 4 == 0 : i == 0 || i == places.size() || places[i - 1] / 4 < places[i] / 4;
}

/// `cornersOf(i)` are the points of element i of the network.
template <class CornersOf>
void checkDivision(const Division& division, std::size_t elements, CornersOf cornersOf) {
  std::vector<std::uint32_t> order = division.order;
  std::sort(order.begin(), order.end());
  ASSERT_EQ(order.size(), elements);
  for (std::uint32_t i = 0; i < order.size(); ++i) ASSERT_EQ(order[i], i);
  std::uint32_t end = 0;
  for (const std::vector<Range>& phase : division.phases) {
    std::set<std::uint32_t> points;
    for (const Range& range : phase) {
      ASSERT_EQ(range.begin, end);
      ASSERT_TRUE(beginsABatch(division, range.begin)) << range.begin;
      end = range.end;
      std::set<std::uint32_t> own;
      for (std::uint32_t i = range.begin; i < range.end; ++i)
        for (const std::uint32_t point : cornersOf(division.order[i])) own.insert(point);
      for (const std::uint32_t point : own)
        ASSERT_TRUE(points.insert(point).second) << "two ranges of a phase share point " << point;
    }
  }
  EXPECT_EQ(end, elements);
}

void checkSprings(const SharedNetwork& network) {
  checkDivision(divideSprings(*network), network->springs.size(), [&](std::uint32_t i) {
    return std::vector<std::uint32_t>{network->springs[i].a, network->springs[i].b};
  });
}

void checkTetrahedra(const SharedNetwork& network) {
  checkDivision(divideTetrahedra(*network), network->tetrahedra.size(),
                [&](std::uint32_t i) { return network->tetrahedra[i]; });
}

TEST(Division, rangesOfAPhaseShareNoPoint) {
  for (const SharedNetwork& network : {largeCloth(), largeBlock(), test::cubeNetwork()})
    checkSprings(network);
  for (const SharedNetwork& network : {largeBlock(), test::tetrahedralCubeNetwork()})
    checkTetrahedra(network);
}

TEST(Division, largeBodiesHaveSeveralRangesAndSmallOnesHaveOne) {
  EXPECT_EQ(divideSprings(*largeCloth()).phases[0].size(), 4u);
  EXPECT_GE(divideSprings(*largeBlock()).phases[0].size(), 4u);
  EXPECT_GE(divideTetrahedra(*largeBlock()).phases[0].size(), 2u);
  EXPECT_FALSE(divideSprings(*test::closedCubeNetwork()).isDivided());
  EXPECT_FALSE(divideTetrahedra(*test::tetrahedralCubeNetwork()).isDivided());
}

TEST(Division, everyPointIsInOneSlab) {
  const SharedNetwork network = largeBlock();
  const Division division = divideSprings(*network);
  ASSERT_EQ(division.pointRanges.size(), division.phases[0].size());
  std::vector<std::uint32_t> points = division.points;
  std::sort(points.begin(), points.end());
  ASSERT_EQ(points.size(), network->restPoints.size());
  for (std::uint32_t i = 0; i < points.size(); ++i) ASSERT_EQ(points[i], i);
  std::uint32_t end = 0;
  for (const Range& range : division.pointRanges) {
    EXPECT_EQ(range.begin, end);
    end = range.end;
  }
  EXPECT_EQ(end, points.size());
}

/// Where every spring reaches far, nothing is gained.
TEST(Division, networksOfLongSpringsStayWhole) {
  auto network = std::make_shared<SpringNetwork>(*test::chainNetwork(99));
  network->springs.clear();
  for (std::uint32_t a = 0; a < 100; ++a)
    for (std::uint32_t b = a + 1; b < 100; ++b)
      network->springs.push_back({a, b, SpringKind::Structural, 1.0});
  EXPECT_FALSE(divideSprings(*network).isDivided());
  checkSprings(network);
}

// --- the step ----------------------------------------------------------------------------------------------

/// A deformed, moving body with a held point and plane contacts under every third one.
struct DividedBody : test::SteppedTestBody {
  DividedBody(const SharedNetwork& network, double damping) : SteppedTestBody(network, 300.0, damping) {
    disturb();
    for (Eigen::Index i = 0; i < state.position.cols(); i += 3) {
      PlaneContact row;
      row.point = static_cast<std::uint32_t>(i);
      row.friction = 0.3;
      row.restitution = i % 2 ? 0.5 : 0.0;
      row.touch = state.position.col(i) - Eigen::Vector3d(0.0, 0.01, 0.0);
      rows.push_back(row);
    }
    contacts = &rows;
    stepped();
  }
  std::vector<PlaneContact> rows;
};

TEST(Team, stepsABodyToTheBitsOfOneThread) {
  if (!canStepSpringBatches()) GTEST_SKIP() << "this machine has neither AVX2 nor NEON";
  for (const SharedNetwork& network : {largeCloth(), largeBlock()})
    for (const double damping : {0.0, 0.2})
      for (const unsigned helpers : {0u, 1u, 4u})
        leadTeam(helpers, [&](Team& team) {
          SCOPED_TRACE(testing::Message() << network->springs.size() << " springs, " << helpers);
          DividedBody alone(network, damping), together(network, damping);
          SpringBatchArrays batches;
          together.group.bodies[0].springBatches = &batches;
          together.group.team = &team;
          for (int tick = 0; tick < 6; ++tick) {
            stepVerlet(alone.group, 1.0 / 60, 7);
            stepVerlet(together.group, 1.0 / 60, 7);
            ASSERT_TRUE((alone.state.position.array() == together.state.position.array()).all()) << tick;
            ASSERT_TRUE((alone.state.velocity.array() == together.state.velocity.array()).all()) << tick;
            ASSERT_EQ(alone.group.bodies[0].errorRate, together.group.bodies[0].errorRate) << tick;
          }
          EXPECT_TRUE(alone.state.position.allFinite());
        });
}

}  // namespace
}  // namespace limber
