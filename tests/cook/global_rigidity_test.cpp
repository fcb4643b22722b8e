// SPDX-License-Identifier: Zlib
#include "analysis/analysis.h"

#include "mesh/random.h"
#include "support/network_shapes.h"
#include "support/networks.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <utility>

using limber::isGloballyRigid;
using limber::SpringNetwork;
using network_shapes::bare;

namespace {

/// Returns a network of all pairs of `points` except those in `without`.
SpringNetwork graph(std::uint32_t points,
                    const std::vector<std::pair<std::uint32_t, std::uint32_t>>& without) {
  SpringNetwork network;
  for (std::uint32_t a = 0; a < points; ++a) {
    network.restPoints.emplace_back(a, a * a, a * a * a);
    for (std::uint32_t b = a + 1; b < points; ++b)
      if (std::find(without.begin(), without.end(), std::make_pair(a, b)) == without.end())
        network.springs.push_back({a, b, limber::SpringKind::Structural, 1.0});
  }
  return network;
}

bool isJoined(const SpringNetwork& network, std::uint32_t a, std::uint32_t b) {
  return std::any_of(network.springs.begin(), network.springs.end(),
                     [&](const limber::NetworkSpring& s) { return s.a == a && s.b == b; });
}

SpringNetwork withRandomBraces(SpringNetwork network, int count, std::uint64_t seed) {
  limber::Random random(seed);
  while (count > 0) {
    std::uint32_t a = random.below(network.restPoints.size()), b = random.below(network.restPoints.size());
    if (a > b) std::swap(a, b);
    if (a == b || isJoined(network, a, b)) continue;
    network.springs.push_back({a, b, limber::SpringKind::Brace, 1.0});
    --count;
  }
  return network;
}

}  // namespace

TEST(GlobalRigidity, smallGraphs) {
  EXPECT_TRUE(isGloballyRigid(graph(2, {})));
  EXPECT_TRUE(isGloballyRigid(graph(4, {})));
  EXPECT_FALSE(isGloballyRigid(graph(4, {{0, 3}})));
  EXPECT_TRUE(isGloballyRigid(graph(5, {})));
  // two tetrahedra with a common triangle: each can be mirrored at it
  EXPECT_FALSE(isGloballyRigid(graph(5, {{3, 4}})));
  EXPECT_TRUE(isGloballyRigid(graph(6, {{0, 1}, {2, 3}}))) << "globally rigid: 13 springs, 4-connected";
  EXPECT_FALSE(isGloballyRigid(graph(6, {{0, 1}, {0, 2}}))) << "point 0 has three neighbours";
}

TEST(GlobalRigidity, completeBipartiteGraphsAsConnellyFoundThem) {
  // K(5,5) in space has enough springs, connectivity and redundancy, but is not globally rigid (Connelly
  // 1991); no count shows this.
  std::vector<std::pair<std::uint32_t, std::uint32_t>> without;
  for (std::uint32_t side : {0u, 5u})
    for (std::uint32_t a = side; a < side + 5; ++a)
      for (std::uint32_t b = a + 1; b < side + 5; ++b) without.emplace_back(a, b);
  EXPECT_FALSE(isGloballyRigid(graph(10, without)));
}

TEST(GlobalRigidity, triangulationsNeedOneBrace) {
  // Jordan, Tanigawa 2019: never without braces; with one brace if they are 4-connected
  for (const auto make : {network_shapes::ico42, network_shapes::noise162}) {
    const SpringNetwork network = *bare(make());
    EXPECT_FALSE(isGloballyRigid(network));
    for (std::uint64_t seed = 1; seed <= 3; ++seed)
      EXPECT_TRUE(isGloballyRigid(withRandomBraces(network, 1, seed)));
  }
  const SpringNetwork hull = *bare(network_shapes::hull60());
  std::vector<int> neighbours(60, 0);
  for (const auto& s : hull.springs) ++neighbours[s.a], ++neighbours[s.b];
  ASSERT_EQ(*std::min_element(neighbours.begin(), neighbours.end()), 3);
  SpringNetwork braced = withRandomBraces(hull, 1, 1);
  EXPECT_FALSE(isGloballyRigid(braced)) << "points with three neighbours fold through their plane";
  for (std::uint32_t i = 0; i < 60; ++i)
    for (std::uint32_t j = 0; j < 60 && neighbours[i] == 3; ++j)
      if (i != j && !isJoined(braced, std::min(i, j), std::max(i, j))) {
        braced.springs.push_back({std::min(i, j), std::max(i, j), limber::SpringKind::Brace, 1.0});
        break;
      }
  EXPECT_TRUE(isGloballyRigid(braced));
}

TEST(GlobalRigidity, thePapersCubes) {
  EXPECT_FALSE(isGloballyRigid(*bare(network_shapes::cube8())));
  EXPECT_TRUE(isGloballyRigid(*limber::test::cubeNetwork()));
  EXPECT_TRUE(isGloballyRigid(*limber::test::fullCubeNetwork()));
}

TEST(GlobalRigidity, specialPositionsDoNotMatter) {
  SpringNetwork flat = *limber::test::cubeNetwork();
  for (Eigen::Vector3d& p : flat.restPoints) p.y() = 0.0;
  EXPECT_TRUE(isGloballyRigid(flat));
}
