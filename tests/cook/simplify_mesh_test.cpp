// SPDX-License-Identifier: Zlib
#include <limber/mesh.h>

#include "mesh/triangle_bvh.h"
#include "support/small_meshes.h"
#include "support/test_shapes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

using limber::simplify;
using limber::TriangleBvh;
using limber::TriangleMesh;
using limber::WeldedMesh;
using test_shapes::welded;

namespace {

WeldedMesh coarse(const TriangleMesh& mesh, std::uint32_t points) { return welded(*simplify(mesh, points)); }

double volume(const WeldedMesh& mesh) {
  double sum = 0.0;
  for (const limber::Triangle& t : mesh.triangles)
    sum += mesh.points[t[0]].dot(mesh.points[t[1]].cross(mesh.points[t[2]])) / 6.0;
  return sum;
}

/// Returns the Euler characteristic of a closed surface, with half of three edges per triangle.
long eulerNumber(const WeldedMesh& mesh) {
  return static_cast<long>(mesh.points.size()) - static_cast<long>(mesh.triangles.size()) / 2;
}

/// Returns the larger of the two one-sided distances from the points of one surface to the other surface.
double hausdorff(const WeldedMesh& a, const WeldedMesh& b) {
  const TriangleBvh onA(a.points, a.triangles), onB(b.points, b.triangles);
  double largest = 0.0;
  for (const auto& p : a.points) largest = std::max(largest, onB.nearest(p).distance);
  for (const auto& p : b.points) largest = std::max(largest, onA.nearest(p).distance);
  return largest;
}

/// A sheet of 2 n^2 triangles in the square from 0 to 1 of the xy plane.
TriangleMesh sheet(std::uint32_t n) {
  TriangleMesh mesh;
  for (std::uint32_t j = 0; j <= n; ++j) {
    for (std::uint32_t i = 0; i <= n; ++i) mesh.positions.emplace_back(double(i) / n, double(j) / n, 0.0);
  }
  for (std::uint32_t j = 0; j < n; ++j) {
    for (std::uint32_t i = 0; i < n; ++i) {
      const std::uint32_t corner = j * (n + 1) + i;
      mesh.triangles.push_back({corner, corner + 1, corner + n + 2});
      mesh.triangles.push_back({corner, corner + n + 2, corner + n + 1});
    }
  }
  return mesh;
}

}  // namespace

TEST(Simplify, keepsShapeAndTopology) {
  struct Case {
    const char* name;
    TriangleMesh mesh;
    std::uint32_t points;
    double volumeError;  // a polyhedron with corners near the surface is smaller than a round body: by 2/n of
                         // its area times its radius of curvature
    double distance;     // as a fraction of the size
  };
  const Case cases[] = {{"rabbit", test_shapes::rabbit(0.025), 150, 0.04, 0.03},
                        {"horseshoe", test_shapes::horseshoe(0.025), 150, 0.04, 0.03},
                        {"torus", test_shapes::roundTorus(0.03), 200, 0.03, 0.02},
                        {"figure", test_shapes::figure(), 150, 0.04, 0.03},
                        {"noise sphere", test_shapes::noiseSphere(4), 300, 0.02, 0.02},
                        {"cube", small_meshes::cube(16), 60, 0.002, 0.005},
                        {"L", test_shapes::lShape(), 30, 0.002, 0.01}};
  for (const Case& c : cases) {
    SCOPED_TRACE(c.name);
    const WeldedMesh fine = welded(c.mesh), result = coarse(c.mesh, c.points);
    ASSERT_TRUE(fine.report.watertight());
    EXPECT_EQ(result.points.size(), c.points);
    EXPECT_TRUE(result.report.watertight());
    EXPECT_EQ(result.report.components, 1u);
    EXPECT_EQ(eulerNumber(result), eulerNumber(fine));
    EXPECT_NEAR(volume(result) / volume(fine), 1.0, c.volumeError);
    EXPECT_LT(hausdorff(fine, result), c.distance);
  }
}

TEST(Simplify, theCornersOfACube) {
  const WeldedMesh result = coarse(small_meshes::cube(10), 8);
  ASSERT_EQ(result.points.size(), 8u);
  // the error terms of the points move corners by less than a thousandth of the size
  for (const auto& p : result.points) EXPECT_LT((p.cwiseAbs().array() - 0.5).abs().maxCoeff(), 0.01);
}

TEST(Simplify, fewestPoints) {
  const WeldedMesh result = coarse(small_meshes::icosphere(2), 4);
  EXPECT_EQ(result.points.size(), 4u);
  EXPECT_TRUE(result.report.watertight());
  EXPECT_GT(volume(result), 0.0);
}

TEST(Simplify, borderOfASheetStays) {
  const WeldedMesh result = coarse(sheet(20), 40);
  EXPECT_EQ(result.points.size(), 40u);
  EXPECT_EQ(result.report.nonManifoldEdges, 0u);
  // a disc has V - E + F = 1, and 3 F = 2 E - B
  EXPECT_EQ(2 * result.points.size(), result.triangles.size() + result.report.openEdges + 2);
  double area = 0.0;
  for (const auto& t : result.triangles)
    area += 0.5 *
            (result.points[t[1]] - result.points[t[0]]).cross(result.points[t[2]] - result.points[t[0]]).z();
  EXPECT_NEAR(area, 1.0, 0.005);
}

TEST(Simplify, componentsStayApart) {
  const TriangleMesh ball = small_meshes::icosphere(3);
  const WeldedMesh result =
      coarse(small_meshes::joined(ball, small_meshes::moved(ball, {1.31, 0, 0}, 0.3)), 60);
  EXPECT_EQ(result.points.size(), 60u);
  EXPECT_EQ(result.report.components, 2u);
  EXPECT_TRUE(result.report.watertight());
}

/// A cylinder with caps of fans: slivers that each collapse makes a little worse.
TEST(Simplify, fansAndBandsOfSliversGetAsFewPoints) {
  for (const std::uint32_t sides : {48u, 200u, 1000u}) {
    TriangleMesh mesh;
    mesh.positions = {{0, 0, 0}, {0, 0, 0.5}};
    for (std::uint32_t i = 0; i < sides; ++i)
      for (const double height : {0.0, 0.5})
        mesh.positions.emplace_back(0.3 * std::cos(2 * M_PI * i / sides),
                                    0.3 * std::sin(2 * M_PI * i / sides), height);
    for (std::uint32_t i = 0; i < sides; ++i) {
      const std::uint32_t low = 2 + 2 * i, next = 2 + 2 * ((i + 1) % sides);
      for (const limber::Triangle& t :
           {limber::Triangle{0, next, low}, limber::Triangle{1, low + 1, next + 1},
            limber::Triangle{low, next, next + 1}, limber::Triangle{low, next + 1, low + 1}})
        mesh.triangles.push_back(t);
    }
    const WeldedMesh coarser = coarse(mesh, 50);
    EXPECT_EQ(coarser.points.size(), 50u) << sides;
    EXPECT_TRUE(coarser.report.watertight()) << sides;
    EXPECT_NEAR(volume(coarser), M_PI * 0.09 * 0.5, 0.05 * M_PI * 0.09 * 0.5) << sides;
  }
}

TEST(Simplify, smallMeshesComeBackAsTheyAre) {
  const WeldedMesh cube = welded(small_meshes::cube()), result = coarse(small_meshes::cube(), 100);
  EXPECT_EQ(result.points.size(), 8u);
  EXPECT_EQ(result.triangles, cube.triangles);
}

TEST(Simplify, nonManifoldMeshesKeepTheirSeams) {
  TriangleMesh mesh = sheet(8);  // with a fin on an edge in the middle
  mesh.positions.emplace_back(0.5, 0.5, 0.4);
  mesh.triangles.push_back({40, 41, static_cast<std::uint32_t>(mesh.positions.size() - 1)});
  const auto result = simplify(mesh, 20);
  ASSERT_TRUE(result);
  EXPECT_EQ(welded(*result).report.nonManifoldEdges, 1u);
}

TEST(Simplify, farFromTheOrigin) {
  TriangleMesh mesh = test_shapes::rabbit(0.04);
  const WeldedMesh near = coarse(mesh, 100);
  for (auto& p : mesh.positions) p += Eigen::Vector3d(1000, -2000, 500);
  const WeldedMesh far = coarse(mesh, 100);
  ASSERT_EQ(far.points.size(), near.points.size());
  EXPECT_NEAR(volume(far) / volume(near), 1.0, 0.01);
}

TEST(Simplify, sameEveryTime) {
  const TriangleMesh mesh = test_shapes::figure();
  EXPECT_EQ(simplify(mesh, 100)->positions, simplify(mesh, 100)->positions);
}

TEST(Simplify, errors) {
  EXPECT_EQ(simplify(small_meshes::cube(), 3).error(),
            "simplify() cannot make a mesh of 3 points, it needs 4 or more");
  EXPECT_EQ(simplify(TriangleMesh{}, 10).error(), "the mesh has no vertices");
}
