// SPDX-License-Identifier: Zlib
// Checks of meshes, and what welding makes of them.
#include <limber/mesh.h>

#include "support/small_meshes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <random>

using limber::kNoPoint;
using limber::Result;
using limber::Triangle;
using limber::TriangleMesh;
using limber::validate;
using limber::weld;
using limber::WeldedMesh;

TEST(TriangleMesh, soundMesh) { EXPECT_EQ(validate(small_meshes::tetrahedron()).error(), ""); }

TEST(TriangleMesh, emptyMesh) { EXPECT_EQ(validate(TriangleMesh{}).error(), "the mesh has no vertices"); }

TEST(TriangleMesh, noTriangles) {
  TriangleMesh mesh = small_meshes::tetrahedron();
  mesh.triangles.clear();
  EXPECT_EQ(validate(mesh).error(), "the mesh has no triangles");
}

TEST(TriangleMesh, outOfRangeIndex) {
  TriangleMesh mesh = small_meshes::tetrahedron();
  mesh.triangles[2][1] = 4;
  EXPECT_EQ(validate(mesh).error(), "triangle 2 uses vertex 4 of 4");
}

TEST(TriangleMesh, nanPosition) {
  TriangleMesh mesh = small_meshes::tetrahedron();
  mesh.positions[3].y() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(validate(mesh).error(), "the position of vertex 3 is not finite");
}

TEST(TriangleMesh, infinitePosition) {
  TriangleMesh mesh = small_meshes::tetrahedron();
  mesh.positions[1].z() = -std::numeric_limits<double>::infinity();
  EXPECT_EQ(validate(mesh).error(), "the position of vertex 1 is not finite");
}

TEST(TriangleMesh, positionBeyondTheBound) {
  TriangleMesh mesh = small_meshes::tetrahedron();
  mesh.positions[1].z() = -1e62;
  EXPECT_EQ(validate(mesh).error(), "the position of vertex 1 has a coordinate beyond 1e9");
}

TEST(TriangleMesh, optionalArraysHaveOneEntryPerVertex) {
  TriangleMesh mesh = small_meshes::tetrahedron();
  mesh.normals.resize(4);
  mesh.uvs.resize(4);
  EXPECT_EQ(validate(mesh).error(), "");
  mesh.uvs.resize(5);
  EXPECT_EQ(validate(mesh).error(), "5 texture coordinates for 4 vertices");
  mesh.normals.resize(3);
  EXPECT_EQ(validate(mesh).error(), "3 normals for 4 vertices");
}

TEST(TriangleMesh, degenerateTrianglesAreNoError) {
  EXPECT_EQ(validate(small_meshes::collinearTriangle()).error(), "");
  TriangleMesh mesh = small_meshes::singleTriangle();
  mesh.triangles[0] = {1, 1, 1};
  EXPECT_EQ(validate(mesh).error(), "");
}

// --- welding -----------------------------------------------------------------------------------------------

namespace {

WeldedMesh welded(const TriangleMesh& mesh, double tolerance = 0.0) {
  Result<WeldedMesh> result = weld(mesh, tolerance);
  EXPECT_TRUE(result) << result.error();
  return result ? *result : WeldedMesh{};
}

/// A square of two triangles that share the diagonal, each with its own three vertices.
TriangleMesh splitSquare() {
  TriangleMesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  mesh.triangles = {{0, 1, 2}, {3, 4, 5}};
  return mesh;
}

}  // namespace

TEST(MeshWeld, invalidMeshIsRefused) {
  EXPECT_EQ(weld(TriangleMesh{}).error(), "the mesh has no vertices");
  TriangleMesh mesh = small_meshes::singleTriangle();
  mesh.triangles[0][2] = 900;
  EXPECT_EQ(weld(mesh).error(), "triangle 0 uses vertex 900 of 3");
}

TEST(MeshWeld, duplicateVertices) {
  const WeldedMesh square = welded(splitSquare());
  EXPECT_EQ(square.vertexToPoint, (std::vector<std::uint32_t>{0, 1, 2, 0, 2, 3}));
  EXPECT_EQ(square.triangles, (std::vector<Triangle>{{0, 1, 2}, {0, 2, 3}}));
  EXPECT_EQ(square.keptTriangles, (std::vector<std::uint32_t>{0, 1}));
  EXPECT_EQ(square.report.vertices, 6u);
  EXPECT_EQ(square.report.points, 4u);
  EXPECT_EQ(square.report.openEdges, 4u);
}

TEST(MeshWeld, seamVerticesWeldToOnePoint) {
  const TriangleMesh mesh = small_meshes::cube(3);
  const WeldedMesh cube = welded(mesh);
  EXPECT_EQ(cube.report.vertices, 6u * 16u);
  EXPECT_EQ(cube.report.points, 6u * 9u + 2u);
  EXPECT_TRUE(cube.report.watertight());
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    EXPECT_EQ(cube.points[cube.vertexToPoint[i]], mesh.positions[i]);
  }
}

TEST(MeshWeld, negativeZeroEqualsZero) {
  TriangleMesh mesh = splitSquare();
  mesh.positions[3] = {-0.0, -0.0, -0.0};
  EXPECT_EQ(welded(mesh).report.points, 4u);
}

TEST(MeshWeld, withoutToleranceOnlyEqualBitsMerge) {
  TriangleMesh mesh = splitSquare();
  mesh.positions[4].x() = std::nextafter(1.0, 2.0);
  EXPECT_EQ(welded(mesh).report.points, 5u);
}

TEST(MeshWeld, pointsAreNumberedInOrderOfFirstUse) {
  TriangleMesh mesh = small_meshes::tetrahedron();
  mesh.triangles = {{3, 1, 2}};
  EXPECT_EQ(welded(mesh).vertexToPoint, (std::vector<std::uint32_t>{kNoPoint, 0, 1, 2}));
}

TEST(MeshWeld, twoEqualCorners) {
  TriangleMesh mesh = splitSquare();
  mesh.triangles.push_back({0, 3, 5});  // vertices 0 and 3 are one point
  const WeldedMesh square = welded(mesh);
  EXPECT_EQ(square.report.degenerateTriangles, 1u);
  EXPECT_EQ(square.report.triangles, 2u);
}

TEST(MeshWeld, collinearTriangle) {
  const WeldedMesh mesh = welded(small_meshes::collinearTriangle());
  EXPECT_EQ(mesh.report.degenerateTriangles, 1u);
  EXPECT_EQ(mesh.keptTriangles, (std::vector<std::uint32_t>{1}));
  EXPECT_EQ(mesh.vertexToPoint[2], kNoPoint) << "only the collinear triangle used it";
}

TEST(MeshWeld, areaIsJudgedByShapeNotBySize) {
  for (const double size : {1e-300, 1e-30, 1.0, 1e9}) {
    TriangleMesh thin = small_meshes::singleTriangle();
    thin.positions = {{0, 0, 0}, {size, 0, 0}, {0.5 * size, 1e-5 * size, 0}};
    EXPECT_TRUE(weld(thin)) << size;
    thin.positions[2].y() = 1e-9 * size;
    EXPECT_FALSE(weld(thin)) << size;
  }
}

TEST(MeshWeld, nothingButDegenerateTriangles) {
  TriangleMesh mesh = small_meshes::collinearTriangle();
  mesh.triangles = {{0, 1, 2}, {3, 3, 0}};
  EXPECT_EQ(weld(mesh).error(), "none of the 2 triangles has an area");
}

TEST(MeshWeld, duplicateTrianglesInAnyOrder) {
  TriangleMesh mesh = small_meshes::tetrahedron();
  const Triangle t = mesh.triangles[3];
  mesh.triangles.push_back({t[1], t[2], t[0]});
  mesh.triangles.push_back({t[2], t[1], t[0]});
  const WeldedMesh tetrahedron = welded(mesh);
  EXPECT_EQ(tetrahedron.report.duplicateTriangles, 2u);
  EXPECT_EQ(tetrahedron.keptTriangles, (std::vector<std::uint32_t>{0, 1, 2, 3}));
  EXPECT_TRUE(tetrahedron.report.watertight());
}

TEST(MeshWeld, isolatedVertex) {
  const WeldedMesh mesh = welded(small_meshes::isolatedVertex());
  EXPECT_EQ(mesh.report.isolatedVertices, 1u);
  EXPECT_EQ(mesh.vertexToPoint, (std::vector<std::uint32_t>{kNoPoint, 0, 1, 2}));
  EXPECT_EQ(mesh.points[0], Eigen::Vector3d(0, 0, 0));
}

TEST(MeshWeld, twoIslands) {
  const limber::MeshReport report = welded(small_meshes::twoIslands()).report;
  EXPECT_EQ(report.components, 2u);
  EXPECT_TRUE(report.watertight());
}

TEST(MeshWeld, islandsThatShareAPointAreOneComponent) {
  TriangleMesh mesh = small_meshes::twoIslands();
  mesh.positions[4] = mesh.positions[1];
  EXPECT_EQ(welded(mesh).report.components, 1u);
}

TEST(MeshWeld, openEdges) {
  const limber::MeshReport report = welded(small_meshes::singleTriangle()).report;
  EXPECT_EQ(report.openEdges, 3u);
  EXPECT_EQ(report.nonManifoldEdges, 0u);
  EXPECT_EQ(report.inconsistentEdges, 0u);
  EXPECT_FALSE(report.watertight());
}

TEST(MeshWeld, nonManifoldEdge) {
  const limber::MeshReport report = welded(small_meshes::nonManifoldEdge()).report;
  EXPECT_EQ(report.nonManifoldEdges, 1u);
  EXPECT_EQ(report.openEdges, 6u);
  EXPECT_EQ(report.inconsistentEdges, 0u);
}

TEST(MeshWeld, flippedTriangle) {
  const limber::MeshReport report = welded(small_meshes::flippedTriangle()).report;
  EXPECT_EQ(report.inconsistentEdges, 3u);
  EXPECT_EQ(report.openEdges, 0u);
  EXPECT_FALSE(report.watertight());
}

TEST(MeshWeld, descriptionOfASoundMesh) {
  EXPECT_EQ(describe(welded(small_meshes::cube()).report),
            "24 vertices -> 8 points, 12 triangles, 1 component, watertight");
}

TEST(MeshWeld, descriptionNamesEveryDefect) {
  limber::MeshReport report;
  report.vertices = report.points = report.triangles = report.components = 1;
  report.degenerateTriangles = report.duplicateTriangles = report.isolatedVertices = 2;
  report.openEdges = report.nonManifoldEdges = 1;
  report.inconsistentEdges = 3;
  EXPECT_EQ(describe(report),
            "1 vertex -> 1 point, 1 triangle, 1 component, 2 degenerate triangles, 2 duplicate triangles, "
            "2 isolated vertices, 1 open edge, 1 non-manifold edge, 3 inconsistent edges");
}

// --- tolerances --------------------------------------------------------------------------------------------

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

TEST(MeshWeldTolerance, manyVerticesStayApart) {
  const TriangleMesh mesh = randomTriangles(50000, 2);
  EXPECT_EQ(weld(mesh, 1e-9)->report.points, 150000u);
}
