// SPDX-License-Identifier: Zlib
#include <limber/mesh.h>

#include "support/small_meshes.h"

#include <gtest/gtest.h>

#include <limits>

using limber::kNoPoint;
using limber::Result;
using limber::Triangle;
using limber::TriangleMesh;
using limber::weld;
using limber::WeldedMesh;

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
