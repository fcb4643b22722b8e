// SPDX-License-Identifier: Zlib
// Construction of surfaces: errors, edges, sides, and owners of features.
#include "support/moving_shapes.h"
#include "support/small_meshes.h"

#include <gtest/gtest.h>

namespace limber {
namespace {

using Eigen::Vector3d;
using test::MovingShape;

std::string errorOf(const SurfaceFeatures& features) {
  Points points = Points::Zero(3, 3);
  points.col(1) = Vector3d::UnitX();
  points.col(2) = Vector3d::UnitY();
  return makeSurfaceTopology(points, features).error();
}

TEST(SurfaceTopology, namesWhatIsWrong) {
  SurfaceFeatures f;
  f.triangles = {{0, 1, 2}, {0, 1, 3}};
  EXPECT_EQ(errorOf(f), "triangle 1 uses point 3 of 3");
  f.triangles = {{0, 1, 1}};
  EXPECT_EQ(errorOf(f), "triangle 0 has point 1 twice");
  f.triangles.clear();
  f.segments = {{2, 2}};
  EXPECT_EQ(errorOf(f), "segment 0 has point 2 twice");
  f.segments.clear();
  f.vertices = {0, 7};
  EXPECT_EQ(errorOf(f), "vertex 1 uses point 7 of 3");
  Points points = Points::Zero(3, 2);
  points(1, 1) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(makeSurfaceTopology(points, {}).error(), "the position of point 1 is not finite");
}

TEST(SurfaceTopology, closedPiecesAreOneSided) {
  const MovingShape box = test::boxShape(Vector3d::Ones(), 0.0), cloth = test::clothShape(2, 1.0, 0.0);
  EXPECT_EQ(box.topology.edges.size(), 18u);
  for (const std::uint8_t oneSided : box.topology.oneSided) EXPECT_TRUE(oneSided);
  for (const std::uint8_t oneSided : cloth.topology.oneSided) EXPECT_FALSE(oneSided);
  SurfaceFeatures ground;
  ground.triangles = cloth.topology.triangles;
  ground.solid = limber::Solid::AllPieces;
  const auto topology = makeSurfaceTopology(cloth.position, ground);
  ASSERT_TRUE(topology);
  for (const std::uint8_t oneSided : topology->oneSided) EXPECT_TRUE(oneSided);
}

/// Expects that each vertex and edge is owned by one element.
void expectEachOnce(const SurfaceTopology& t, std::size_t vertices, std::size_t edges) {
  std::vector<int> vertexUses(static_cast<std::size_t>(t.rest.cols())), edgeUses(t.edges.size());
  std::size_t vertexSum = 0, edgeSum = 0;
  for (const SurfaceElement& e : t.elements) {
    for (const std::uint32_t v : e.vertices) {
      if (v == kNoFeature) continue;
      EXPECT_EQ(++vertexUses[v], 1);
      ++vertexSum;
    }
    for (const std::uint32_t edge : e.edges) {
      if (edge == kNoFeature) continue;
      EXPECT_EQ(++edgeUses[edge], 1);
      ++edgeSum;
    }
  }
  EXPECT_EQ(vertexSum, vertices);
  EXPECT_EQ(edgeSum, edges);
}

TEST(SurfaceTopology, eachFeatureIsInOneElementsCare) {
  expectEachOnce(test::boxShape(Vector3d::Ones(), 0.0).topology, 8, 18);
  expectEachOnce(test::ballShape(2, 0.0).topology, 162, 480);
  expectEachOnce(test::ropeShape(5, 0.1, 0.0).topology, 6, 5);
  expectEachOnce(test::sphereShape(0.1).topology, 1, 0);
}

/// The six diagonals on the flat faces of a rigid box have no contacts.
TEST(SurfaceTopology, rigidShapesLeaveFlatEdgesOut) {
  expectEachOnce(test::boxShape(Vector3d::Ones(), 0.0, true).topology, 8, 12);
}

TEST(SurfaceTopology, segmentsThatAreEdgesOfTrianglesCountOnce) {
  SurfaceFeatures f;
  f.triangles = {{0, 1, 2}};
  f.segments = {{2, 1}, {3, 2}, {2, 3}};
  f.vertices = {3, 4};
  Points points = Points::Random(3, 5);
  const auto topology = makeSurfaceTopology(points, f);
  ASSERT_TRUE(topology);
  EXPECT_EQ(topology->edges.size(), 4u);
  expectEachOnce(*topology, 5, 4);
}

TEST(SurfaceTopology, mayBeEmpty) {
  MovingShape nothing = test::makeShape(Points::Zero(3, 0), {}, 0.1),
              box = test::boxShape(Vector3d::Ones(), 0.0);
  EXPECT_TRUE(test::contactsOf(nothing, box, 1.0).empty());
  EXPECT_TRUE(test::contactsOf(box, nothing, 1.0).empty());
}

}  // namespace
}  // namespace limber
