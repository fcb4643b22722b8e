// SPDX-License-Identifier: Zlib
// Bounding box trees compared with tests of all pairs, and the inside test of a box.
#include "collide/surface_contacts.h"
#include "mesh/surface.h"
#include "support/moving_shapes.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace limber {
namespace {

using Eigen::Vector3d;
using test::MovingShape;

/// Returns randomly placed triangles with random motions.
MovingShape randomSoup(int triangles, std::mt19937& random) {
  Points points(3, 3 * triangles);
  SurfaceFeatures features;
  for (int i = 0; i < triangles; ++i) {
    const Vector3d centre = test::randomVector(random);
    for (int k = 0; k < 3; ++k) points.col(3 * i + k) = centre + 0.2 * test::randomVector(random);
    const auto first = static_cast<std::uint32_t>(3 * i);
    features.triangles.push_back({first, first + 1, first + 2});
  }
  MovingShape shape = test::makeShape(points, features, 0.01);
  for (int i = 0; i < points.cols(); ++i) shape.motion.col(i) = 0.1 * test::randomVector(random);
  return shape;
}

Eigen::AlignedBox3d boxOf(const MovingShape& shape, const Triangle& triangle) {
  Eigen::AlignedBox3d box;
  for (const std::uint32_t v : triangle)
    for (const double time : {0.0, 1.0}) {
      const Vector3d corner = shape.position.col(v) + time * shape.motion.col(v);
      box.extend(corner - Vector3d::Constant(shape.radius));
      box.extend(corner + Vector3d::Constant(shape.radius));
    }
  return box;
}

LeafPairs elementsOf(const LeafPairs& leaves, const SurfaceTopology& a, const SurfaceTopology& b) {
  LeafPairs elements;
  for (const auto& [i, j] : leaves) elements.emplace_back(a.nodes[i].element, b.nodes[j].element);
  return elements;
}

TEST(SurfaceTree, findsThePairsThatAreNear) {
  std::mt19937 random(1);
  for (int trial = 0; trial < 20; ++trial) {
    MovingShape a = randomSoup(60, random), b = randomSoup(1 + 7 * trial, random);
    LeafPairs waiting, leaves, expected;
    findNearLeaves(a.surface(), b.surface(), 0.05, waiting, leaves);
    LeafPairs near = elementsOf(leaves, a.topology, b.topology);
    for (std::uint32_t i = 0; i < a.topology.triangles.size(); ++i)
      for (std::uint32_t j = 0; j < b.topology.triangles.size(); ++j) {
        const auto boxA = boxOf(a, a.topology.triangles[i]), boxB = boxOf(b, b.topology.triangles[j]);
        const Vector3d gap = (boxA.min() - boxB.max()).cwiseMax(boxB.min() - boxA.max());
        if (gap.maxCoeff() <= 0.05) expected.emplace_back(i, j);
      }
    std::sort(near.begin(), near.end());
    EXPECT_EQ(near, expected) << "trial " << trial;
    EXPECT_FALSE(expected.empty());
    EXPECT_TRUE(areLeavesNear(a.surface(), b.surface(), 0.05, waiting));
  }
}

SweptBox boxOf(const MovingShape& shape, const Edge& edge) {
  return merged(shape.boxes.points[edge[0]], shape.boxes.points[edge[1]]);
}

/// Lists what of the surface is near the box.
void listNear(MovingShape& shape, const SweptBox& box, double margin, NearFeatures& near) {
  listNearFeatures(shape.surface(), {}, {box, box, margin}, near);
}

TEST(NearFeatures, findThePairsOfEdgesThatAreNear) {
  constexpr double kMargin = 0.05, kRounded = 1e-6;  // m
  std::mt19937 random(3);
  for (int trial = 0; trial < 20; ++trial) {
    MovingShape a = randomSoup(60, random), b = randomSoup(1 + 7 * trial, random);
    b.move(Eigen::Affine3d(Eigen::Translation3d(1.0, 0.2, 0.0)));
    NearFeatures nearA, nearB;
    b.surface();
    listNear(a, b.boxes.vertices, kMargin, nearA);
    listNear(b, nearA.edgeBoxes.bounds(), kMargin, nearB);
    EXPECT_LT(nearA.edges.size(), a.topology.edges.size());
    LeafPairs overlapping, near, expected;
    nearA.edgeBoxes.findNear(nearB.edgeBoxes, overlapping);
    for (const auto& [i, j] : overlapping) {
      const std::uint32_t edgeA = nearA.edges[i].edge, edgeB = nearB.edges[j].edge;
      const double apart = separation(boxOf(a, a.topology.edges[edgeA]), boxOf(b, b.topology.edges[edgeB]));
      EXPECT_LT(apart, kMargin + kRounded);
      if (apart <= kMargin) near.emplace_back(edgeA, edgeB);
    }
    for (std::uint32_t i = 0; i < a.topology.edges.size(); ++i)
      for (std::uint32_t j = 0; j < b.topology.edges.size(); ++j)
        if (separation(boxOf(a, a.topology.edges[i]), boxOf(b, b.topology.edges[j])) <= kMargin)
          expected.emplace_back(i, j);
    std::sort(near.begin(), near.end());
    EXPECT_EQ(near, expected) << "trial " << trial;
  }
}

TEST(SurfaceTree, findsThePairsOfItself) {
  std::mt19937 random(2);
  MovingShape a = randomSoup(80, random);
  LeafPairs waiting, leaves, allPairs;
  findNearLeaves(a.surface(), a.surface(), 0.02, waiting, leaves);
  MovingShape copy = a;
  findNearLeaves(a.surface(), copy.surface(), 0.02, waiting, allPairs);
  allPairs.erase(
      std::remove_if(allPairs.begin(), allPairs.end(), [](const auto& p) { return p.first >= p.second; }),
      allPairs.end());
  std::sort(leaves.begin(), leaves.end());
  std::sort(allPairs.begin(), allPairs.end());
  EXPECT_EQ(leaves, allPairs);
  EXPECT_GT(leaves.size(), 20u);
}

TEST(SurfaceTree, nearestPlaceIsThatOfAllTriangles) {
  std::mt19937 random(4);
  MovingShape shape = randomSoup(200, random);
  for (int trial = 0; trial < 200; ++trial) {
    const Vector3d point = 1.5 * test::randomVector(random);
    const NearestOnSurface nearest = nearestOnSurface(shape.surface(), point, 10.0);
    double expected = 10.0;
    for (const Triangle& t : shape.topology.triangles) {
      const TriangleCorners corners{shape.position.col(t[0]), shape.position.col(t[1]),
                                    shape.position.col(t[2])};
      const Vector3d w = nearestBarycentric(corners, point);
      expected =
          std::min(expected, (w[0] * corners[0] + w[1] * corners[1] + w[2] * corners[2] - point).norm());
    }
    EXPECT_NEAR(nearest.distance, expected, 1e-14);
    EXPECT_EQ(nearestOnSurface(shape.surface(), point, 0.99 * expected).triangle, kNoFeature);
  }
}

/// A randomly rotated box: `behind` means inside, also nearest to an edge or a corner.
TEST(SurfaceTree, behindIsInside) {
  std::mt19937 random(5);
  int inside = 0;
  for (int trial = 0; trial < 500; ++trial) {
    MovingShape box = test::boxShape({1, 2, 3}, 0.0);
    const Eigen::Affine3d pose = test::randomTurn(random);
    box.move(pose);
    const Vector3d local = Vector3d(0.7, 1.4, 2.1).cwiseProduct(test::randomVector(random));
    const bool expected = (local.cwiseAbs().array() < Eigen::Array3d(0.5, 1.0, 1.5)).all();
    EXPECT_EQ(nearestOnSurface(box.surface(), pose * local, 10.0).behind, expected) << local.transpose();
    inside += expected;
  }
  EXPECT_GT(inside, 100);
}

TEST(SurfaceTree, boundsHoldAllTimes) {
  MovingShape box = test::boxShape(Vector3d::Ones(), 0.1);
  box.setMotion({1, -2, 0});
  const SweptBox bounds = sweptBounds(box.surface());
  EXPECT_LT((bounds.low - Eigen::Array4d(-0.6, -2.6, -0.6, 0)).abs().maxCoeff(), 1e-15);
  EXPECT_LT((bounds.high - Eigen::Array4d(1.6, 0.6, 0.6, 0)).abs().maxCoeff(), 1e-15);
}

/// The nearest points of two random segments: moving either along its segment must not reduce the distance.
TEST(ClosestPoints, segmentsComeNearestWhereNeitherSideCanGetNearer) {
  std::mt19937 random(6);
  for (int trial = 0; trial < 1000; ++trial) {
    Vector3d p[4];
    for (Vector3d& x : p) x = test::randomVector(random);
    if (trial % 4 == 0) p[3] = p[2] + 0.7 * (p[1] - p[0]);  // parallel
    const SegmentPair pair = nearestOnSegments(p[0], p[1], p[2], p[3]);
    const Vector3d difference = p[0] + pair.a * (p[1] - p[0]) - p[2] - pair.b * (p[3] - p[2]);
    const double slopeA = difference.dot(p[1] - p[0]), slopeB = -difference.dot(p[3] - p[2]);
    // the distance is convex: these are the conditions of its minimum, to rounding
    EXPECT_TRUE(pair.a >= 1.0   ? slopeA <= 1e-12
                : pair.a <= 0.0 ? slopeA >= -1e-12
                                : std::abs(slopeA) < 1e-12);
    EXPECT_TRUE(pair.b >= 1.0   ? slopeB <= 1e-12
                : pair.b <= 0.0 ? slopeB >= -1e-12
                                : std::abs(slopeB) < 1e-12);
  }
}

}  // namespace
}  // namespace limber
