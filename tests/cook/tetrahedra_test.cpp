// SPDX-License-Identifier: Zlib
// Tetrahedra that fill closed meshes: shape, surface, volume, components, errors.
#include "network/tetrahedra.h"
#include "mesh/surface.h"
#include "mesh/triangle_bvh.h"
#include "support/small_meshes.h"
#include "support/test_shapes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace limber {
namespace {

constexpr double kDegrees = 180.0 / 3.14159265358979323846;

double volumeOfAll(const TetrahedralMesh& mesh) {
  double sum = 0.0;
  for (const Tetrahedron& t : mesh.tetrahedra) sum += volumeOf(mesh.points, t);
  return sum;
}

double volumeInside(const WeldedMesh& mesh) {
  double sum = 0.0;
  for (const Triangle& t : mesh.triangles)
    sum += mesh.points[t[0]].dot(mesh.points[t[1]].cross(mesh.points[t[2]])) / 6.0;
  return std::abs(sum);
}

/// Expects positive volumes, bounded angles, and a closed manifold surface, at every edge and every point.
void expectValid(const TetrahedralMesh& mesh) {
  for (const Tetrahedron& t : mesh.tetrahedra) {
    ASSERT_GT(volumeOf(mesh.points, t), 0.0);
    const DihedralAngles angles = dihedralAngles(mesh.points, t);
    ASSERT_GE(angles.smallest * kDegrees, 10.0);
    ASSERT_LE(angles.largest * kDegrees, 165.0);
  }
  const EdgeDefects defects = findEdgeDefects(mesh.surface);
  EXPECT_EQ(defects.open + defects.nonManifold + defects.inconsistent, 0u);
  // one fan around each point: the edges opposite to it are connected
  std::vector<std::vector<Triangle>> fans(mesh.points.size());
  for (const Triangle& t : mesh.surface)
    for (const std::uint32_t point : t) fans[point].push_back(t);
  for (std::uint32_t point = 0; point < fans.size(); ++point) {
    std::vector<Triangle> opposite;  // edges opposite to the point, as triangles without it
    for (const Triangle& t : fans[point]) {
      Triangle edge = t;
      std::replace(edge.begin(), edge.end(), point, t[0] == point ? t[1] : t[0]);
      opposite.push_back(edge);
    }
    if (!opposite.empty()) {
      EXPECT_EQ(findComponents(mesh.points.size(), opposite).count, 1u) << "point " << point;
    }
  }
}

struct Case {
  const char* name;
  TriangleMesh mesh;
  std::size_t points;
  double volumeError;  ///< error of a lattice with this number of points
};

std::vector<Case> cases() {
  return {{"cube", small_meshes::cube(1), 300, 1e-9},
          {"ball", small_meshes::icosphere(3), 300, 0.03},
          {"L", test_shapes::lShape(), 300, 1e-9},
          {"L, fine", test_shapes::lShape(), 1200, 1e-9},
          {"torus", test_shapes::torus(), 300, 0.04},
          {"cylinder", test_shapes::cylinder(), 300, 0.02},
          {"star", test_shapes::star(), 300, 0.03},
          {"star, fine", test_shapes::star(), 1200, 0.01},
          {"figure", test_shapes::figure(), 300, 0.02},
          {"noise", test_shapes::noiseSphere(2), 300, 0.03},
          {"rabbit", test_shapes::rabbit(0.04), 300, 0.02},
          {"horseshoe", test_shapes::horseshoe(0.02), 300, 0.06},
          {"tetrahedron", small_meshes::tetrahedron(), 100, 0.02},
          {"two islands", small_meshes::twoIslands(), 200, 0.04}};
}

TEST(Tetrahedra, fillConcaveAndRoundBodiesSoundly) {
  for (const Case& c : cases()) {
    SCOPED_TRACE(c.name);
    const WeldedMesh mesh = *weld(c.mesh);
    const Result<TetrahedralMesh> filled = fillWithPoints(mesh, c.points);
    ASSERT_TRUE(filled) << filled.error();
    expectValid(*filled);
    EXPECT_NEAR(volumeOfAll(*filled) / volumeInside(mesh), 1.0, c.volumeError);
    EXPECT_EQ(findComponents(filled->points.size(), filled->surface).count, mesh.report.components);
    // whole rows of the lattice appear or disappear at once
    EXPECT_NEAR(std::log(static_cast<double>(filled->points.size()) / static_cast<double>(c.points)), 0.0,
                0.5);
  }
}

TEST(Tetrahedra, keepTheirSurfaceWithinHalfASpacing) {
  const double spacing = 0.1;
  for (const TriangleMesh& shape : {test_shapes::lShape(), test_shapes::torus(), test_shapes::rabbit(0.04)}) {
    const WeldedMesh mesh = *weld(shape);
    const TetrahedralMesh filled = *fillWithTetrahedra(mesh, spacing);
    const TriangleBvh meshBvh(mesh.points, mesh.triangles), filledBvh(filled.points, filled.surface);
    for (const Triangle& t : filled.surface)
      for (const std::uint32_t point : t)
        EXPECT_LT(meshBvh.nearest(filled.points[point]).distance, 0.5 * spacing);
    // parts thinner than the lattice, such as the tips of ears, are cut off
    std::vector<double> distances;
    for (const Eigen::Vector3d& point : mesh.points) distances.push_back(filledBvh.nearest(point).distance);
    std::nth_element(distances.begin(),
                     distances.begin() + static_cast<std::ptrdiff_t>(distances.size() * 9 / 10),
                     distances.end());
    EXPECT_LT(distances[distances.size() * 9 / 10], 0.7 * spacing);
  }
}

TEST(Tetrahedra, findTheCornersOfACubeThatLiesAskewInTheLattice) {
  TriangleMesh cube = small_meshes::cube(1);
  const Eigen::AngleAxisd rotation(0.5, Eigen::Vector3d(1, 2, 3).normalized());
  for (Eigen::Vector3d& p : cube.positions) p = rotation * p;
  const TetrahedralMesh filled = *fillWithTetrahedra(*weld(cube), 0.15);
  expectValid(filled);
  EXPECT_NEAR(volumeOfAll(filled), 1.0, 0.015) << "cut off by the lattice it would miss 0.05";
}

TEST(Tetrahedra, turnAnInwardSurfaceAround) {
  const TriangleMesh cube = small_meshes::inverted(small_meshes::cube(2));
  EXPECT_NEAR(volumeOfAll(*fillWithTetrahedra(*weld(cube), 0.25)), 1.0, 1e-9);
}

TEST(Tetrahedra, leaveHollowsHollow) {
  const TriangleMesh ball = small_meshes::icosphere(3);
  const TriangleMesh hollow = small_meshes::inverted(small_meshes::moved(ball, {0, 0, 0}, 0.5));
  const WeldedMesh mesh = *weld(small_meshes::joined(ball, hollow));
  const TetrahedralMesh filled = *fillWithTetrahedra(mesh, 0.2);
  expectValid(filled);
  EXPECT_EQ(findComponents(filled.points.size(), filled.surface).count, 2u);
  EXPECT_NEAR(volumeOfAll(filled) / volumeInside(mesh), 1.0, 0.03);
}

TEST(Tetrahedra, joinPiecesThatLieWithinEachOther) {
  const TriangleMesh cube = small_meshes::cube(1);
  const TriangleMesh both = small_meshes::joined(cube, small_meshes::moved(cube, {0.5, 0.25, 0}));
  const TetrahedralMesh filled = *fillWithTetrahedra(*weld(both), 0.125);
  expectValid(filled);
  EXPECT_NEAR(volumeOfAll(filled), 2.0 - 0.5 * 0.75, 0.02);
}

TEST(Tetrahedra, areTheSameEachTime) {
  const WeldedMesh mesh = *weld(test_shapes::figure());
  const TetrahedralMesh a = *fillWithPoints(mesh, 300), b = *fillWithPoints(mesh, 300);
  EXPECT_EQ(a.points, b.points);
  EXPECT_EQ(a.tetrahedra, b.tetrahedra);
}

TEST(Tetrahedra, sayWhatTheyCannotFill) {
  EXPECT_EQ(fillWithPoints(*weld(small_meshes::singleTriangle()), 100).error(),
            "the mesh is not closed: it has 3 open edges; wrap() closes it, cook() does so by itself");
  EXPECT_EQ(fillWithPoints(*weld(small_meshes::flippedTriangle()), 100).error(),
            "the mesh has no inside: at 3 edges its triangles are oriented against each other; wrap() "
            "orients them");
  const WeldedMesh cube = *weld(small_meshes::cube(1));
  EXPECT_EQ(fillWithPoints(cube, 7).error(), "7 points are too few, there must be 8 or more");
  TriangleMesh flat;  // a square with two sides
  flat.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  flat.triangles = {{0, 1, 2}, {0, 2, 3}, {1, 0, 3}, {1, 3, 2}};
  EXPECT_EQ(fillWithPoints(*weld(flat), 100).error(), "the mesh encloses no volume");
  EXPECT_EQ(fillWithTetrahedra(cube, 0.0).error(), "the spacing is 0, it must be above 0");
  EXPECT_EQ(fillWithTetrahedra(cube, 1e-3).error(),
            "the spacing of 0.001 m needs a lattice of 2.04e+09 sites, it may have 4e+06");
}

/// The plate needs lattices as fine as its thickness, of some ten thousand points. Finer ones, of millions,
/// were tried, too.
TEST(Tetrahedra, ofAThinPlateAreNoMoreThanItNeeds) {
  TriangleMesh plate = small_meshes::cube(1);
  for (Eigen::Vector3d& p : plate.positions) p.y() *= 0.02;
  const Result<TetrahedralMesh> filled = fillWithPoints(*weld(plate), 60);
  ASSERT_TRUE(filled) << filled.error();
  EXPECT_LT(filled->points.size(), 5000u);
}

TEST(Tetrahedra, sayWhichPieceIsTooThin) {
  const TriangleMesh cube = small_meshes::cube(1);
  const TriangleMesh mesh =
      small_meshes::joined(cube, small_meshes::moved(cube, {0.913, 0.087, 0.041}, 0.02));
  EXPECT_EQ(fillWithTetrahedra(*weld(mesh), 0.25).error().substr(0, 34),
            "piece 1 of the mesh is missed: it ");
}

TEST(Tetrahedra, comeApartWhereTheyMeetInAnEdgeOrAPoint) {
  // two tetrahedra share only the edge 0 1; the third shares only the point 0 with them
  TetrahedralMesh mesh;
  mesh.points = {{0, 0, 0},  {0, 0, 1},   {1, 0, 0},   {0, 1, 0},    {-1, 0, 0},
                 {0, -2, 0}, {0, -1, -1}, {1, -1, -1}, {0, -0.5, -2}};
  mesh.tetrahedra = {{0, 2, 3, 1}, {0, 4, 5, 1}, {0, 6, 7, 8}};
  for (Tetrahedron& t : mesh.tetrahedra)
    if (volumeOf(mesh.points, t) < 0.0) std::swap(t[2], t[3]);
  makeManifold(mesh, 0.0);
  EXPECT_EQ(mesh.tetrahedra.size(), 2u) << "the smaller one at the edge goes";
  EXPECT_EQ(mesh.points.size(), 8u) << "the point in common is doubled";
  expectValid(mesh);
}

}  // namespace
}  // namespace limber
