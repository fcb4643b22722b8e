// SPDX-License-Identifier: Zlib
// Triangulation of faces with more than three corners.
#include <limber/mesh.h>

#include "import/temporary_folder.h"
#include "support/constants.h"

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include <cmath>
#include <sstream>

using Eigen::Vector3d;
using limber::Result;
using limber::Triangle;
using limber::TriangleMesh;
using limber::test::kPi;

namespace {

/// Imports a file of one face with these corners.
TriangleMesh importPolygon(const std::vector<Vector3d>& corners) {
  std::ostringstream obj;
  obj.precision(9);
  for (const Vector3d& p : corners) obj << "v " << p.x() << ' ' << p.y() << ' ' << p.z() << '\n';
  obj << 'f';
  for (std::size_t i = 1; i <= corners.size(); ++i) obj << ' ' << i;
  const TemporaryFolder folder;
  Result<TriangleMesh> mesh = limber::importMesh(folder.write("a.obj", obj.str() + "\n"));
  EXPECT_TRUE(mesh) << mesh.error();
  return mesh ? *mesh : TriangleMesh{};
}

Vector3d areaVector(const TriangleMesh& mesh, const Triangle& t) {
  const Vector3d& a = mesh.positions[t[0]];
  return (mesh.positions[t[1]] - a).cross(mesh.positions[t[2]] - a) / 2.0;
}

/// Expects n - 2 triangles that all face along `normal` and together have the polygon's area. So they cover
/// it, and none is outside.
void expectCovers(const std::vector<Vector3d>& corners, const Vector3d& normal, double area) {
  const TriangleMesh mesh = importPolygon(corners);
  EXPECT_EQ(mesh.triangles.size(), corners.size() - 2);
  double sum = 0.0;
  for (const Triangle& t : mesh.triangles) {
    EXPECT_GT(areaVector(mesh, t).dot(normal), 0.0) << t[0] << ' ' << t[1] << ' ' << t[2];
    sum += areaVector(mesh, t).norm();
  }
  EXPECT_NEAR(sum / area, 1.0, 1e-6);
}

/// A star with `tips` tips at radius 1 and as many notches at radius 0.3, counter-clockwise around z.
std::vector<Vector3d> starPolygon(int tips) {
  std::vector<Vector3d> corners;
  for (int i = 0; i < 2 * tips; ++i) {
    const double angle = kPi * i / tips, radius = i % 2 == 0 ? 1.0 : 0.3;
    corners.emplace_back(radius * std::cos(angle), radius * std::sin(angle), 0.0);
  }
  return corners;
}

double starArea(int tips) { return tips * 0.3 * std::sin(kPi / tips); }

}  // namespace

TEST(MeshImportPolygons, convexPolygonIsAFan) {
  const TriangleMesh mesh = importPolygon({{0, 0, 0}, {2, 0, 0}, {3, 1, 0}, {2, 2, 0}, {0, 2, 0}});
  EXPECT_EQ(mesh.triangles, (std::vector<Triangle>{{0, 1, 2}, {0, 2, 3}, {0, 3, 4}}));
}

TEST(MeshImportPolygons, concaveQuad) {
  const std::vector<Vector3d> arrow{{0, 0, 0}, {2, 0, 0}, {2, 2, 0}, {1.5, 0.5, 0}};
  for (std::size_t first = 0; first < 4; ++first) {
    std::vector<Vector3d> rotated = arrow;
    std::rotate(rotated.begin(), rotated.begin() + static_cast<std::ptrdiff_t>(first), rotated.end());
    expectCovers(rotated, {0, 0, 1}, 1.0);
  }
}

TEST(MeshImportPolygons, starsInAnyPlane) {
  for (const Vector3d& normal :
       {Vector3d(0, 0, 1), Vector3d(0, 0, -1), Vector3d(1, 0, 0), Vector3d(0, -1, 0), Vector3d(-1, 2, 0.5)}) {
    const Eigen::Quaterniond rotation = Eigen::Quaterniond::FromTwoVectors(Vector3d::UnitZ(), normal);
    std::vector<Vector3d> corners = starPolygon(7);
    for (Vector3d& corner : corners) corner = rotation * corner + Vector3d(3, 4, 5);
    expectCovers(corners, normal, starArea(7));
  }
}

TEST(MeshImportPolygons, sizeDoesNotMatter) {
  for (const double size : {1e-9, 1e-4, 1e6}) {
    std::vector<Vector3d> corners = starPolygon(5);
    for (Vector3d& corner : corners) corner *= size;
    expectCovers(corners, {0, 0, 1}, starArea(5) * size * size);
  }
}

TEST(MeshImportPolygons, cornersOnAnEdgeMakeNoFlatTriangles) {
  expectCovers({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}, {3, 3, 0}, {0, 3, 0}, {0, 1, 0}}, {0, 0, 1}, 9.0);
}

TEST(MeshImportPolygons, repeatedCornersAreLeftToWeld) {
  const TriangleMesh mesh = importPolygon({{0, 0, 0}, {1, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}});
  EXPECT_EQ(mesh.triangles.size(), 3u);
  const limber::MeshReport report = limber::weld(mesh)->report;
  EXPECT_EQ(report.degenerateTriangles, 1u);
  EXPECT_EQ(report.openEdges, 4u);
}

TEST(MeshImportPolygons, polygonsWithoutAreaAreLeftToWeld) {
  const TriangleMesh mesh = importPolygon({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}});
  EXPECT_EQ(mesh.triangles.size(), 2u);
  EXPECT_FALSE(limber::weld(mesh));
}

TEST(MeshImportPolygons, crossedPolygonLosesNoCorner) {
  const TriangleMesh mesh = importPolygon({{0, 0, 0}, {1, 1, 0}, {1, 0, 0}, {0, 1, 0}, {-1, 0.3, 0}});
  EXPECT_EQ(mesh.triangles.size(), 3u);
  EXPECT_EQ(limber::weld(mesh)->report.isolatedVertices, 0u);
}

TEST(MeshImportPolygons, polygonOfManyCorners) {
  std::vector<Vector3d> circle;
  for (int i = 0; i < 5000; ++i)
    circle.emplace_back(std::cos(2e-4 * kPi * i * 2), std::sin(2e-4 * kPi * i * 2), 0);
  EXPECT_EQ(importPolygon(circle).triangles.size(), 4998u);
  expectCovers(starPolygon(400), {0, 0, 1}, starArea(400));
}
