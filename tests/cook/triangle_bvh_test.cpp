// SPDX-License-Identifier: Zlib
#include "mesh/triangle_bvh.h"

#include "mesh/surface.h"
#include "support/small_meshes.h"
#include "support/test_shapes.h"

#include <limber/mesh.h>

#include <gtest/gtest.h>

#include <cmath>

using Eigen::Vector3d;
using limber::kPi;
using limber::nearestBarycentric;
using limber::pointAt;
using limber::solidAngle;
using limber::TriangleBvh;
using limber::TriangleCorners;
using limber::TriangleHit;
using limber::WeldedMesh;
using test_shapes::welded;

namespace {

TriangleBvh bvhOf(const WeldedMesh& mesh) { return TriangleBvh(mesh.points, mesh.triangles); }

TriangleCorners corners(const WeldedMesh& mesh, std::size_t triangle) {
  const limber::Triangle& t = mesh.triangles[triangle];
  return {mesh.points[t[0]], mesh.points[t[1]], mesh.points[t[2]]};
}

/// Returns the i-th of a sequence of evenly distributed points in the box of 2 x `half` (R2 sequence of M.
/// Roberts).
Vector3d evenPoint(int i, double half) {
  const auto fraction = [&](double step) { return std::fmod(0.5 + step * (i + 1), 1.0); };
  return half * (2.0 * Vector3d(fraction(0.8191725134), fraction(0.6710436067), fraction(0.5497004779)) -
                 Vector3d::Ones());
}

double bruteDistance(const WeldedMesh& mesh, const Vector3d& p) {
  double best = HUGE_VAL;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
    best = std::min(best, (pointAt(corners(mesh, i), nearestBarycentric(corners(mesh, i), p)) - p).norm());
  return best;
}

double bruteWinding(const WeldedMesh& mesh, const Vector3d& p) {
  double angle = 0.0;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) angle += solidAngle(corners(mesh, i), p);
  return angle / (4.0 * kPi);
}

}  // namespace

TEST(TriangleBvh, nearestIsTheNearestOfAll) {
  const WeldedMesh mesh = welded(test_shapes::figure());
  const TriangleBvh bvh = bvhOf(mesh);
  for (int i = 0; i < 300; ++i) {
    const Vector3d p = evenPoint(i, 0.7);
    const TriangleHit hit = bvh.nearest(p);
    ASSERT_TRUE(hit);
    EXPECT_NEAR(hit.distance, bruteDistance(mesh, p), 1e-14);
    EXPECT_NEAR((hit.position - p).norm(), hit.distance, 1e-14);
    EXPECT_LT((pointAt(corners(mesh, hit.triangle), hit.barycentric) - hit.position).norm(), 1e-14);
    EXPECT_GE(hit.barycentric.minCoeff(), -1e-12);
  }
}

TEST(TriangleBvh, equallyNearTrianglesGiveTheLowestIndex) {
  const WeldedMesh cube = welded(small_meshes::cube(4));
  const TriangleHit hit = bvhOf(cube).nearest(Vector3d(0.5, 0.5, 0.5));
  std::uint32_t lowest = 0;
  while ((corners(cube, lowest)[0] - Vector3d(0.5, 0.5, 0.5)).norm() > 0.0 &&
         (corners(cube, lowest)[1] - Vector3d(0.5, 0.5, 0.5)).norm() > 0.0 &&
         (corners(cube, lowest)[2] - Vector3d(0.5, 0.5, 0.5)).norm() > 0.0) {
    ++lowest;
  }
  EXPECT_EQ(hit.triangle, lowest);
  EXPECT_EQ(hit.distance, 0.0);
}

TEST(TriangleBvh, nearestThatDoesNotFaceAgainstANormal) {
  const TriangleBvh bvh = bvhOf(welded(small_meshes::cube()));
  const Vector3d p(0.1, 0.2, 0.3);
  EXPECT_NEAR(bvh.nearest(p).distance, 0.2, 1e-15);
  EXPECT_NEAR(bvh.nearestWithin(p, HUGE_VAL, {0, 0, 1}).distance, 0.2, 1e-15);
  EXPECT_NEAR(bvh.nearestWithin(p, HUGE_VAL, {-3, -2, -1}).distance, 0.6, 1e-15) << "the face at x = -0.5";
  EXPECT_NEAR(bvh.nearestWithin(p, HUGE_VAL, Vector3d::Zero()).distance, 0.2, 1e-15);
}

TEST(TriangleBvh, raysMeetTheFirstTriangle) {
  const WeldedMesh cube = welded(small_meshes::cube(4));
  const TriangleBvh bvh = bvhOf(cube);
  const Vector3d x = Vector3d::UnitX();
  // y = 0 and z = 0.1 pass through edges of the grid, which must not let the ray through
  for (const Vector3d& origin : {Vector3d(-2, 0, 0), Vector3d(-2, 0.1, 0.2), Vector3d(-2, 0.25, 0.1)}) {
    EXPECT_NEAR(bvh.firstHit(origin, x, 0.0, 10.0).distance, 1.5, 1e-14);
    EXPECT_NEAR(bvh.firstHit(origin, x, 1.6, 10.0).distance, 2.5, 1e-14) << "from within, the far side";
    EXPECT_FALSE(bvh.firstHit(origin, x, 0.0, 1.4));
    EXPECT_FALSE(bvh.firstHit(origin, x, 2.6, 10.0));
    EXPECT_FALSE(bvh.firstHit(origin, -x, 0.0, 10.0));
  }
}

TEST(TriangleBvh, raysFromWithinAlwaysMeetAClosedSurface) {
  const TriangleBvh bvh = bvhOf(welded(small_meshes::icosphere(3)));
  for (int i = 0; i < 2000; ++i) {
    const TriangleHit hit = bvh.firstHit(Vector3d(0.1, 0.2, 0.3), evenPoint(i, 1.0).normalized(), 0.0, 10.0);
    ASSERT_TRUE(hit) << i;
    EXPECT_NEAR(hit.position.norm(), 1.0, 0.01);
  }
}

TEST(TriangleBvh, windingNumber) {
  const WeldedMesh mesh = welded(test_shapes::figure());
  const TriangleBvh bvh = bvhOf(mesh);
  for (int i = 0; i < 500; ++i) {
    const Vector3d p = evenPoint(i, 0.5);
    // far nodes are approximated by dipoles; their errors of some hundredths mostly cancel
    EXPECT_NEAR(bvh.windingNumber(p), bruteWinding(mesh, p), 0.05);
    EXPECT_EQ(bvh.inside(p), bruteWinding(mesh, p) > 0.5);
  }
}

TEST(TriangleBvh, distanceFromASphereAndItsInside) {
  const TriangleBvh bvh = bvhOf(welded(small_meshes::icosphere(4)));
  // 2 562 points: the triangles are up to 1.3e-3 below the sphere
  for (int i = 0; i < 300; ++i) {
    const Vector3d p = evenPoint(i, 1.2);
    const double distance = bvh.nearest(p).distance;
    EXPECT_NEAR(bvh.inside(p) ? -distance : distance, p.norm() - 1.0, 2e-3);
  }
}

TEST(TriangleBvh, withoutTriangles) {
  const TriangleBvh bvh({}, {});
  EXPECT_FALSE(bvh.nearest(Vector3d::Zero()));
  EXPECT_FALSE(bvh.firstHit(Vector3d::Zero(), Vector3d::UnitX(), 0.0, 1.0));
  EXPECT_EQ(bvh.windingNumber(Vector3d::Zero()), 0.0);
}

TEST(StaysInside, everyChordOfAConvexBody) {
  for (const auto& mesh : {welded(small_meshes::cube(4)), welded(small_meshes::icosphere(2))}) {
    const TriangleBvh bvh = bvhOf(mesh);
    for (std::size_t a = 0; a < mesh.points.size(); ++a) {
      for (std::size_t b = a + 1; b < mesh.points.size(); ++b)
        EXPECT_TRUE(bvh.staysInside(mesh.points[a], mesh.points[b], 1e-4)) << a << " " << b;
    }
  }
}

/// The notch of the L is the square x, y > 0.
TEST(StaysInside, chordsOfTheLDoNotCrossTheNotch) {
  const WeldedMesh mesh = welded(test_shapes::lShape());
  const TriangleBvh bvh = bvhOf(mesh);
  for (std::size_t a = 0; a < mesh.points.size(); ++a) {
    for (std::size_t b = a + 1; b < mesh.points.size(); ++b) {
      const Vector3d &p = mesh.points[a], &q = mesh.points[b];
      bool leaves = false;
      for (double t = 0.01; t < 0.99; t += 0.005) {
        const Vector3d r = p + t * (q - p);
        leaves = leaves || std::min(r.x(), r.y()) > 1e-3;
      }
      EXPECT_EQ(bvh.staysInside(p, q, 1e-3), !leaves) << p.transpose() << " to " << q.transpose();
    }
  }
}

TEST(StaysInside, chordsAcrossTheHoleOfATorus) {
  const TriangleBvh bvh = bvhOf(welded(test_shapes::roundTorus(0.05)));
  EXPECT_FALSE(bvh.staysInside({-0.48, 0, 0}, {0.48, 0, 0}, 1e-3));
  EXPECT_FALSE(bvh.staysInside({-0.22, 0, 0}, {0.22, 0, 0}, 1e-3));
  EXPECT_TRUE(bvh.staysInside({-0.48, 0, 0}, {-0.22, 0, 0}, 1e-3));
}

TEST(StaysInside, smallHolesDoNotMatter) {
  WeldedMesh mesh = welded(small_meshes::icosphere(3));
  for (std::size_t i = 0; i < mesh.triangles.size(); i += 40)
    mesh.triangles.erase(mesh.triangles.begin() + static_cast<std::ptrdiff_t>(i));
  const TriangleBvh bvh = bvhOf(mesh);
  int outside = 0;
  for (std::size_t a = 0; a < mesh.points.size(); a += 7) {
    for (std::size_t b = a + 1; b < mesh.points.size(); b += 5)
      outside += bvh.staysInside(mesh.points[a], mesh.points[b], 1e-3) ? 0 : 1;
  }
  // of 11 600 chords, those whose ends are corners of the same hole
  EXPECT_LT(outside, 20);
}
