// SPDX-License-Identifier: Zlib
#include <limber/network_builder.h>

#include <gtest/gtest.h>

#include <cmath>

using limber::buildRope;
using limber::RopeSettings;
using limber::SharedNetwork;
using limber::SpringKind;

namespace {

RopeSettings rope(double length, std::uint32_t segments, double bendingScale) {
  RopeSettings settings;
  settings.length = length;
  settings.segments = segments;
  settings.bendingScale = bendingScale;
  return settings;
}

}  // namespace

TEST(NetworkRope, pointsLieOnTheXAxis) {
  const SharedNetwork network = *buildRope(rope(3.0, 4, 0.1));
  EXPECT_EQ(validate(*network).error(), "");
  EXPECT_EQ(network->kind, limber::NetworkKind::Rope);
  ASSERT_EQ(network->restPoints.size(), 5u);
  for (std::size_t i = 0; i < 5; ++i)
    EXPECT_EQ(network->restPoints[i], Eigen::Vector3d(0.75 * double(i), 0, 0));
  for (const double fraction : network->massFractions) EXPECT_DOUBLE_EQ(fraction, 0.2);
}

TEST(NetworkRope, bendingSpringsSkipOnePoint) {
  const SharedNetwork network = *buildRope(rope(1.0, 10, 0.25));
  std::size_t structural = 0, bending = 0;
  for (const limber::NetworkSpring& spring : network->springs) {
    const bool bends = spring.kind == SpringKind::Bending;
    EXPECT_EQ(spring.b - spring.a, bends ? 2u : 1u);
    EXPECT_EQ(spring.stiffnessScale, bends ? 0.25 : 1.0);
    ++(bends ? bending : structural);
  }
  EXPECT_EQ(structural, 10u);
  EXPECT_EQ(bending, 9u);
}

TEST(NetworkRope, withoutBending) { EXPECT_EQ((*buildRope(rope(1.0, 10, 0.0)))->springs.size(), 10u); }

TEST(NetworkRope, singleSegment) {
  const SharedNetwork network = *buildRope(rope(2.0, 1, 0.1));
  EXPECT_EQ(validate(*network).error(), "");
  ASSERT_EQ(network->springs.size(), 1u);
  EXPECT_EQ(network->restPoints[1].x(), 2.0);
}

TEST(NetworkRope, hasNoSurface) {
  const SharedNetwork network = *buildRope();
  EXPECT_EQ(network->restPoints.size(), 17u);
  EXPECT_TRUE(network->surface.empty());
  EXPECT_TRUE(network->render.triangles.empty());
  EXPECT_TRUE(network->render.vertexToPoint.empty());
}

TEST(NetworkRope, impossibleSettingsAreRefused) {
  EXPECT_EQ(buildRope(rope(0.0, 4, 0.1)).error(), "the length of a rope must be above 0");
  EXPECT_FALSE(buildRope(rope(std::nan(""), 4, 0.1)));
  EXPECT_EQ(buildRope(rope(1.0, 0, 0.1)).error(), "a rope needs at least one segment");
  EXPECT_EQ(buildRope(rope(1.0, 4000000000u, 0.1)).error(),
            "a rope of that many segments has more than ten million points");
  EXPECT_EQ(buildRope(rope(1.0, 4, -0.1)).error(), "the bending scale of a rope must be 0 or more");
  EXPECT_FALSE(buildRope(rope(1.0, 4, std::nan(""))));
  EXPECT_FALSE(buildRope(rope(1.0, 0xffffffffu, 0.1)));
}
