// SPDX-License-Identifier: Zlib
// A network separates along its elements and keeps its sums.
#include "solver/split.h"
#include "support/networks.h"

#include <limber/network_builder.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

namespace limber {
namespace {

/// Separates the elements on both sides of the plane x = `at`.
SplitNetwork splitAt(const SpringNetwork& network, double at) {
  const Elements elements = elementsOf(network);
  SplitRequest request;
  request.place = [&](std::uint32_t point) { return network.restPoints[point]; };
  for (const auto& element : elements.all) {
    double height = 0.0;
    for (std::size_t c = 0; c < elements.corners; ++c) height += network.restPoints[element[c]].x() - at;
    request.side.push_back(height > 0.0 ? 1 : -1);
  }
  return splitNetwork(network, elements, request);
}

double stiffnessOf(const SpringNetwork& network, SpringKind kind) {
  double sum = 0.0;
  for (const NetworkSpring& s : network.springs)
    if (s.kind == kind) sum += s.stiffnessScale;
  return sum;
}

}  // namespace

TEST(Split, aClothKeepsMassTrianglesAndStiffness) {
  ClothSettings shape;
  shape.columns = 6;
  shape.rows = 4;
  const SharedNetwork cloth = *buildCloth(shape);
  const SplitNetwork split = splitAt(*cloth, 0.0);
  ASSERT_TRUE(split.network);
  const SpringNetwork& n = *split.network;
  EXPECT_EQ(validate(n).error(), "");
  EXPECT_EQ(n.restPoints.size(), cloth->restPoints.size() + 5);
  EXPECT_EQ(n.surface.size(), cloth->surface.size());
  EXPECT_EQ(n.render.triangles.size(), cloth->render.triangles.size());
  EXPECT_NEAR(std::accumulate(n.massFractions.begin(), n.massFractions.end(), 0.0), 1.0, 1e-14);
  EXPECT_NEAR(stiffnessOf(n, SpringKind::Structural), stiffnessOf(*cloth, SpringKind::Structural), 1e-12);
  EXPECT_LT(stiffnessOf(n, SpringKind::Bending), stiffnessOf(*cloth, SpringKind::Bending));
  for (std::uint32_t i = 0; i < n.restPoints.size(); ++i) {
    EXPECT_EQ(n.restPoints[i], cloth->restPoints[split.pointOf[i]]);
    if (i < cloth->restPoints.size()) {
      EXPECT_EQ(split.pointOf[i], i);
    }
  }
  for (std::size_t i = 0; i < n.springs.size(); ++i) {
    const NetworkSpring& old = cloth->springs[split.springOf[i]];
    const std::uint32_t a = split.pointOf[n.springs[i].a], b = split.pointOf[n.springs[i].b];
    EXPECT_EQ(std::min(a, b), old.a);
    EXPECT_EQ(std::max(a, b), old.b);
  }
}

TEST(Split, aRopePartsAtOnePoint) {
  const SharedNetwork rope = *buildRope();
  const SplitNetwork split = splitAt(*rope, 0.5);
  ASSERT_TRUE(split.network);
  EXPECT_EQ(split.network->restPoints.size(), rope->restPoints.size() + 1);
  EXPECT_NEAR(stiffnessOf(*split.network, SpringKind::Structural), stiffnessOf(*rope, SpringKind::Structural),
              1e-12);
  EXPECT_EQ(validate(*split.network).error(), "");
}

TEST(Split, tetrahedraGetFacesOnBothSides) {
  const SharedNetwork cube = test::tetrahedralCubeNetwork();
  const Elements elements = elementsOf(*cube);
  SplitRequest request;
  request.place = [&](std::uint32_t point) { return cube->restPoints[point]; };
  request.side = {1, -1, -1, -1, -1, -1};
  const SplitNetwork split = splitNetwork(*cube, elements, request);
  ASSERT_TRUE(split.network);
  EXPECT_EQ(validate(*split.network).error(), "");
  EXPECT_EQ(split.network->tetrahedra.size(), 6u);
  EXPECT_NEAR(
      stiffnessOf(*split.network, SpringKind::Structural) + stiffnessOf(*split.network, SpringKind::Brace),
      stiffnessOf(*cube, SpringKind::Structural) + stiffnessOf(*cube, SpringKind::Brace), 1e-12);
}

TEST(Split, noNetworkWithoutASeparation) {
  const SharedNetwork cloth = *buildCloth();
  EXPECT_FALSE(splitAt(*cloth, 5.0).network);
  // a single edge inside
  const Elements elements = elementsOf(*cloth);
  SplitRequest request;
  request.place = [&](std::uint32_t point) { return cloth->restPoints[point]; };
  request.side.assign(elements.all.size(), 0);
  request.side[100] = 1;
  request.side[101] = -1;
  EXPECT_FALSE(splitNetwork(*cloth, elements, request).network);
}

}  // namespace limber
