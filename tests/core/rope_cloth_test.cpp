// SPDX-License-Identifier: Zlib
// Networks of ropes and of cloths.
#include <limber/network_builder.h>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include <cmath>
#include <map>

using limber::buildCloth;
using limber::buildRope;
using limber::ClothSettings;
using limber::NetworkSpring;
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

TEST(NetworkRope, isUniformAlongTheXAxis) {
  const SharedNetwork network = *buildRope(rope(3.0, 4, 0.1));
  EXPECT_EQ(validate(*network).error(), "");
  EXPECT_EQ(network->kind, limber::NetworkKind::Rope);
  ASSERT_EQ(network->restPoints.size(), 5u);
  for (std::size_t i = 0; i < 5; ++i)
    EXPECT_EQ(network->restPoints[i], Eigen::Vector3d(0.75 * double(i), 0, 0));
  EXPECT_EQ(network->massFractions, (std::vector<double>{0.125, 0.25, 0.25, 0.25, 0.125}));
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
  EXPECT_EQ(buildRope(rope(0.0, 4, 0.1)).error(), "length is 0, must be above 0");
  EXPECT_FALSE(buildRope(rope(std::nan(""), 4, 0.1)));
  EXPECT_EQ(buildRope(rope(1.0, 0, 0.1)).error(), "segments is 0, must be 1 or more");
  EXPECT_EQ(buildRope(rope(1.0, 4000000000u, 0.1)).error(), "segments is 4e+09, must be at most ten million");
  EXPECT_EQ(buildRope(rope(1.0, 4, -0.1)).error(), "bendingScale is -0.1, must be 0 or more");
  EXPECT_FALSE(buildRope(rope(1.0, 4, std::nan(""))));
  EXPECT_FALSE(buildRope(rope(1.0, 0xffffffffu, 0.1)));
}

// --- cloths ------------------------------------------------------------------------------------------------

namespace {

/// 2 m x 3 m in 4 x 6 cells of 0.5 m.
ClothSettings squareCells() {
  ClothSettings settings;
  settings.width = 2.0;
  settings.depth = 3.0;
  settings.columns = 4;
  settings.rows = 6;
  return settings;
}

SharedNetwork validCloth(const ClothSettings& settings) {
  const SharedNetwork network = *buildCloth(settings);
  EXPECT_EQ(validate(*network).error(), "");
  return network;
}

std::map<SpringKind, std::size_t> countKinds(const limber::SpringNetwork& network) {
  std::map<SpringKind, std::size_t> counts;
  for (const NetworkSpring& spring : network.springs) ++counts[spring.kind];
  return counts;
}

}  // namespace

TEST(NetworkCloth, pointsRunAlongXThenZ) {
  const SharedNetwork cloth = validCloth(squareCells());
  EXPECT_EQ(cloth->kind, limber::NetworkKind::Cloth);
  ASSERT_EQ(cloth->restPoints.size(), 35u);
  EXPECT_EQ(cloth->restPoints[0], Eigen::Vector3d(-1.0, 0.0, -1.5));
  EXPECT_EQ(cloth->restPoints[2 * 5 + 3], Eigen::Vector3d(0.5, 0.0, -0.5));  // column 3, row 2
  EXPECT_EQ(cloth->restPoints[34], Eigen::Vector3d(1.0, 0.0, 1.5));
}

TEST(NetworkCloth, massesMayBeEqual) {
  ClothSettings settings = squareCells();
  settings.masses = limber::MassRule::Equal;
  const SharedNetwork cloth = validCloth(settings);
  for (const double fraction : cloth->massFractions) EXPECT_DOUBLE_EQ(fraction, 1.0 / 35.0);
}

TEST(NetworkCloth, massesAreThoseOfAUniformSheet) {
  const SharedNetwork cloth = validCloth(squareCells());
  EXPECT_DOUBLE_EQ(cloth->massFractions[0], 0.25 / 24.0);
  EXPECT_DOUBLE_EQ(cloth->massFractions[2], 0.5 / 24.0);
  EXPECT_DOUBLE_EQ(cloth->massFractions[2 * 5 + 3], 1.0 / 24.0);
  double inertia = 0.0;  // sum of m x^2 of points: that of the sheet, w^2 / 12, and of its cells
  for (std::size_t i = 0; i < 35; ++i)
    inertia += cloth->massFractions[i] * std::pow(cloth->restPoints[i].x(), 2);
  EXPECT_NEAR(inertia, 4.0 / 12.0 + 0.25 / 6.0, 1e-12);
}

TEST(NetworkCloth, springCounts) {
  for (const std::uint32_t columns : {1u, 2u, 3u, 4u}) {
    for (const std::uint32_t rows : {1u, 2u, 7u}) {
      ClothSettings settings;
      settings.columns = columns;
      settings.rows = rows;
      auto counts = countKinds(*validCloth(settings));
      EXPECT_EQ(counts[SpringKind::Structural], columns * (rows + 1) + rows * (columns + 1));
      EXPECT_EQ(counts[SpringKind::Shear], 2 * columns * rows);
      EXPECT_EQ(counts[SpringKind::Bending], (columns - 1) * (rows + 1) + (rows - 1) * (columns + 1));
    }
  }
}

/// Of the sheet of 2 m x 3 m.
bool runsAlongTheBorder(const limber::SpringNetwork& cloth, const NetworkSpring& spring) {
  const Eigen::Vector3d &a = cloth.restPoints[spring.a], &b = cloth.restPoints[spring.b];
  return (a.x() == b.x() && std::abs(a.x()) == 1.0) || (a.z() == b.z() && std::abs(a.z()) == 1.5);
}

TEST(NetworkCloth, springLengthsAndScales) {
  ClothSettings settings = squareCells();
  settings.shearScale = 0.3;
  settings.bendingScale = 0.2;
  const SharedNetwork cloth = validCloth(settings);
  const std::map<SpringKind, std::pair<double, double>> expected{{SpringKind::Structural, {0.5, 1.0}},
                                                                 {SpringKind::Shear, {std::sqrt(0.5), 0.3}},
                                                                 {SpringKind::Bending, {1.0, 0.2}}};
  for (const NetworkSpring& spring : cloth->springs) {
    const auto [length, scale] = expected.at(spring.kind);
    EXPECT_NEAR((cloth->restPoints[spring.a] - cloth->restPoints[spring.b]).norm(), length, 1e-12);
    EXPECT_EQ(spring.stiffnessScale, runsAlongTheBorder(*cloth, spring) ? 0.5 * scale : scale);
  }
}

TEST(NetworkCloth, scalesOfZeroLeaveSpringsOut) {
  ClothSettings settings = squareCells();
  settings.shearScale = 0.0;
  settings.bendingScale = 0.0;
  EXPECT_EQ(countKinds(*validCloth(settings)).size(), 1u);
}

TEST(NetworkCloth, surfaceCoversTheSheetAndFacesUp) {
  const SharedNetwork cloth = validCloth(squareCells());
  double area = 0.0;
  for (const limber::Triangle& t : cloth->surface) {
    const Eigen::Vector3d& a = cloth->restPoints[t[0]];
    const Eigen::Vector3d normal = (cloth->restPoints[t[1]] - a).cross(cloth->restPoints[t[2]] - a);
    EXPECT_DOUBLE_EQ(normal.y(), 0.25);
    EXPECT_EQ(normal.x(), 0.0);
    EXPECT_EQ(normal.z(), 0.0);
    area += normal.y() / 2.0;
  }
  EXPECT_DOUBLE_EQ(area, 6.0);
  EXPECT_EQ(cloth->surface.size(), 48u);
  EXPECT_EQ(cloth->render.triangles, cloth->surface);
}

TEST(NetworkCloth, diagonalsAlternate) {
  const SharedNetwork cloth = validCloth(squareCells());
  const auto usesCorner = [&](std::size_t triangle, std::uint32_t point) {
    const limber::Triangle& t = cloth->surface[triangle];
    return t[0] == point || t[1] == point || t[2] == point;
  };
  EXPECT_TRUE(usesCorner(0, 0) && usesCorner(1, 0)) << "the first cell is split at point 0";
  EXPECT_TRUE(usesCorner(2, 2) && usesCorner(3, 2)) << "the next one at point 2";
}

TEST(NetworkCloth, pictureIsUprightSeenFromAbove) {
  const SharedNetwork cloth = validCloth(squareCells());
  ASSERT_EQ(cloth->render.uvs.size(), 35u);
  EXPECT_EQ(cloth->render.uvs[0], Eigen::Vector2f(0, 1));
  EXPECT_EQ(cloth->render.uvs[4], Eigen::Vector2f(1, 1));
  EXPECT_EQ(cloth->render.uvs[30], Eigen::Vector2f(0, 0));
  EXPECT_EQ(cloth->render.vertexToPoint[17], 17u);
}

TEST(NetworkCloth, impossibleSettingsAreRefused) {
  const auto refused = [](auto change) {
    ClothSettings settings;
    change(settings);
    return !buildCloth(settings);
  };
  EXPECT_TRUE(refused([](ClothSettings& s) { s.width = 0.0; }));
  EXPECT_TRUE(refused([](ClothSettings& s) { s.depth = -1.0; }));
  EXPECT_TRUE(refused([](ClothSettings& s) { s.width = std::nan(""); }));
  EXPECT_TRUE(refused([](ClothSettings& s) { s.columns = 0; }));
  EXPECT_TRUE(refused([](ClothSettings& s) { s.masses = limber::MassRule(7); }));
  EXPECT_TRUE(refused([](ClothSettings& s) { s.thickness = -1.0; }));
  EXPECT_TRUE(refused([](ClothSettings& s) { s.rows = 0; }));
  EXPECT_TRUE(refused([](ClothSettings& s) { s.shearScale = -1.0; }));
  EXPECT_TRUE(refused([](ClothSettings& s) { s.bendingScale = std::nan(""); }));
  EXPECT_TRUE(refused([](ClothSettings& s) { s.columns = s.rows = 0xffff; }));
  EXPECT_TRUE(refused([](ClothSettings& s) { s.columns = 0xffffffffu; }));
  EXPECT_FALSE(refused([](ClothSettings&) {}));
}
