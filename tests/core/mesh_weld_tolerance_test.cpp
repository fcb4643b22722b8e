// SPDX-License-Identifier: Zlib
#include <limber/mesh.h>

#include "support/small_meshes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <random>

using limber::kNoPoint;
using limber::Result;
using limber::TriangleMesh;
using limber::weld;
using limber::WeldedMesh;

namespace {

using Points = std::vector<Eigen::Vector3d>;

/// Returns triangles with one vertex each on the x axis; their other corners are 100 m from all others.
TriangleMesh tipsAt(const std::vector<double>& xs) {
  TriangleMesh mesh;
  for (const double x : xs) mesh.positions.emplace_back(x, 0, 0);
  for (std::uint32_t i = 0; i < xs.size(); ++i) {
    mesh.positions.emplace_back(0, 100 * (i + 1.0), 0);
    mesh.positions.emplace_back(0, 100 * (i + 1.0), 50);
    const auto last = static_cast<std::uint32_t>(mesh.positions.size() - 1);
    mesh.triangles.push_back({i, last - 1, last});
  }
  return mesh;
}

/// Returns the points to which the vertices on the x axis are welded.
std::vector<std::uint32_t> pointsOfTips(const std::vector<double>& xs, double tolerance) {
  Result<WeldedMesh> result = weld(tipsAt(xs), tolerance);
  EXPECT_TRUE(result) << result.error();
  std::vector<std::uint32_t> points = result ? result->vertexToPoint : std::vector<std::uint32_t>(xs.size());
  points.resize(xs.size());
  return points;
}

/// The definition of weld(), implemented directly: each position joins the nearest point within the
/// tolerance, or becomes a new point. Returns for each position the point that it joins.
Points joinByBruteForce(const Points& positions, double tolerance) {
  Points points, joined;
  for (const Eigen::Vector3d& p : positions) {
    std::size_t nearest = 0;
    for (std::size_t k = 1; k < points.size(); ++k) {
      if ((points[k] - p).norm() < (points[nearest] - p).norm()) nearest = k;
    }
    if (points.empty() || (points[nearest] - p).norm() > tolerance) {
      nearest = points.size();
      points.push_back(p);
    }
    joined.push_back(points[nearest]);
  }
  return joined;
}

TriangleMesh randomTriangles(std::size_t count, unsigned seed) {
  std::mt19937 random(seed);
  const auto coordinate = [&] { return static_cast<double>(random()) * 0x1p-31 - 1.0; };
  TriangleMesh mesh;
  for (std::uint32_t i = 0; i < 3 * count; ++i)
    mesh.positions.emplace_back(coordinate(), coordinate(), coordinate());
  for (std::uint32_t i = 0; i < count; ++i) mesh.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  return mesh;
}

using Indices = std::vector<std::uint32_t>;

}  // namespace

TEST(MeshWeldTolerance, mustBeALength) {
  const TriangleMesh mesh = small_meshes::singleTriangle();
  EXPECT_NE(weld(mesh, -1.0).error().find("weld tolerance is -1"), std::string::npos);
  EXPECT_FALSE(weld(mesh, std::numeric_limits<double>::quiet_NaN()));
  EXPECT_FALSE(weld(mesh, std::numeric_limits<double>::infinity()));
}

TEST(MeshWeldTolerance, toleranceMergesNearby) {
  EXPECT_EQ(pointsOfTips({0.0, 0.0009, 0.0011}, 0.001), (Indices{0, 0, 1}));
}

TEST(MeshWeldTolerance, cellBordersDoNotSeparate) {
  EXPECT_EQ(pointsOfTips({-1e-9, 1e-9}, 0.001), (Indices{0, 0}));
  EXPECT_EQ(pointsOfTips({0.0009999, 0.0010001, 0.0019998}, 0.001), (Indices{0, 0, 0}));
}

TEST(MeshWeldTolerance, chainsDoNotCollapse) {
  EXPECT_EQ(pointsOfTips({0.0, 0.75, 1.5, 2.25}, 1.0), (Indices{0, 0, 1, 1}));
}

TEST(MeshWeldTolerance, theNearestPointWins) {
  EXPECT_EQ(pointsOfTips({0.0, 1.5, 0.8}, 1.0), (Indices{0, 1, 1}));
}

TEST(MeshWeldTolerance, theEarlierOfTwoEquallyNearPointsWins) {
  EXPECT_EQ(pointsOfTips({1.5, 0.0, 0.75}, 1.0), (Indices{0, 1, 0}));
  EXPECT_EQ(pointsOfTips({0.0, 1.5, 0.75}, 1.0), (Indices{0, 1, 0}));
}

TEST(MeshWeldTolerance, isolatedVerticesDoNotAttract) {
  TriangleMesh mesh = small_meshes::isolatedVertex();
  mesh.positions[0] = mesh.positions[1] + Eigen::Vector3d(0.01, 0, 0);
  Result<WeldedMesh> result = weld(mesh, 0.1);
  ASSERT_TRUE(result);
  EXPECT_EQ(result->points[0], mesh.positions[1]);
  EXPECT_EQ(result->vertexToPoint[0], kNoPoint);
}

TEST(MeshWeldTolerance, jitteredSeamsCloseAgain) {
  TriangleMesh mesh = small_meshes::cube(4);
  std::mt19937 random(7);
  for (Eigen::Vector3d& p : mesh.positions) p[static_cast<int>(random() % 3)] += 1e-6;
  EXPECT_FALSE(weld(mesh)->report.watertight());
  EXPECT_TRUE(weld(mesh, 1e-5)->report.watertight());
  EXPECT_EQ(weld(mesh, 1e-5)->report.points, 98u);
}

TEST(MeshWeldTolerance, agreesWithSearchOfAll) {
  const TriangleMesh mesh = randomTriangles(300, 1);
  for (const double tolerance : {1e-300, 0.01, 0.1, 0.2}) {
    Result<WeldedMesh> result = weld(mesh, tolerance);
    ASSERT_TRUE(result) << result.error();
    const Points expected = joinByBruteForce(mesh.positions, tolerance);
    for (std::size_t i = 0; i < expected.size(); ++i) {
      const std::uint32_t point = result->vertexToPoint[i];
      if (point == kNoPoint) continue;
      EXPECT_EQ(result->points[point], expected[i]) << "vertex " << i << ", tolerance " << tolerance;
    }
    EXPECT_GT(result->report.points, 20u);
    EXPECT_EQ(result->report.points<mesh.positions.size(), tolerance> 0.05) << tolerance;
  }
}

TEST(MeshWeldTolerance, farFromTheOriginAndHuge) {
  TriangleMesh mesh = small_meshes::cube(2);
  for (Eigen::Vector3d& p : mesh.positions) p += Eigen::Vector3d(1e6, -1e6, 1e6);
  EXPECT_EQ(weld(mesh, 1e-12)->report.points, 26u);
  for (Eigen::Vector3d& p : mesh.positions) p = (p - Eigen::Vector3d(1e6, -1e6, 1e6)) * 1e8;
  EXPECT_EQ(weld(mesh, 1e-12)->report.points, 26u);
}

TEST(MeshWeldTolerance, hugeToleranceMergesEverything) {
  TriangleMesh mesh = small_meshes::cube(2);
  EXPECT_EQ(weld(mesh, 1e308).error(), "none of the 48 triangles has an area");
  for (Eigen::Vector3d& p : mesh.positions) p *= 1e9;
  EXPECT_EQ(weld(mesh, 1.7e308).error(), "none of the 48 triangles has an area");
}

TEST(MeshWeldTolerance, manyVerticesInLinearTime) {
  const TriangleMesh mesh = randomTriangles(50000, 2);
  EXPECT_EQ(weld(mesh, 1e-9)->report.points, 150000u);
}
