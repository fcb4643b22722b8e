// SPDX-License-Identifier: Zlib
#include "mesh/triangle_bvh.h"
#include "support/mass_errors.h"
#include "support/small_meshes.h"
#include "support/test_shapes.h"

#include <limber/mesh.h>
#include <limber/network_builder.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

using Eigen::Vector3d;
using limber::MassRule;
using limber::TriangleMesh;
using limber::WeldedMesh;
using limber::test::MassFractions;
using test_shapes::welded;

namespace {

/// Adds the points of a cubic lattice in the box of 2 x `half` that are inside the mesh by 0.3 spacings.
WeldedMesh withInnerPoints(const TriangleMesh& mesh, double spacing, double half) {
  WeldedMesh filled = welded(mesh);
  const limber::TriangleBvh bvh(filled.points, filled.triangles);
  const int cells = static_cast<int>(half / spacing);
  for (int x = -cells; x <= cells; ++x) {
    for (int y = -cells; y <= cells; ++y) {
      for (int z = -cells; z <= cells; ++z) {
        const Vector3d p = spacing * Vector3d(x, y, z);
        if (bvh.inside(p) && bvh.nearest(p).distance > 0.3 * spacing) filled.points.push_back(p);
      }
    }
  }
  return filled;
}

MassFractions shares(MassRule rule, const WeldedMesh& mesh) {
  return limber::test::shareMass(rule, mesh.points, mesh.triangles);
}

void expectValid(const MassFractions& result, std::size_t points) {
  ASSERT_EQ(result.shares.size(), points);
  EXPECT_NEAR(std::accumulate(result.shares.begin(), result.shares.end(), 0.0), 1.0, 1e-12);
  EXPECT_GT(*std::min_element(result.shares.begin(), result.shares.end()), 0.19 / double(points));
}

}  // namespace

TEST(MassFractions, equal) {
  const MassFractions result = shares(MassRule::Equal, welded(small_meshes::cube()));
  EXPECT_EQ(result.shares, std::vector<double>(8, 0.125));
  EXPECT_NEAR(result.centreError, 0.0, 1e-15);
  EXPECT_NEAR(result.inertiaError, 2.0, 1e-12) << "masses in the corners have three times the inertia";
}

TEST(MassFractions, areaOfATetrahedron) {
  const WeldedMesh mesh = welded(small_meshes::tetrahedron());
  const MassFractions result = shares(MassRule::Area, mesh);
  const double slanted = std::sqrt(3.0) / 2.0, all = 1.5 + slanted;
  EXPECT_NEAR(result.shares[0], 0.5 / all, 1e-15) << "three right-angled triangles, a third of each";
  for (const int i : {1, 2, 3})
    EXPECT_NEAR(result.shares[std::size_t(i)], (1.0 + slanted) / 3.0 / all, 1e-15);
}

/// A tetrahedron with 40 more points very near its first corner, so that three points have nearly the whole
/// area.
TEST(MassFractions, areaIsBounded) {
  TriangleMesh fringed = small_meshes::tetrahedron();
  for (std::uint32_t i = 0; i < 40; ++i) {
    fringed.positions.push_back({1e-5, 1e-5 * (i + 1), 1e-5 * i * i});
    fringed.triangles.push_back({0, 3 + i, 4 + i});
  }
  fringed.triangles[4] = {0, 4, 5};
  const WeldedMesh body = welded(fringed);
  ASSERT_EQ(body.points.size(), 44u);
  const MassFractions result = shares(MassRule::Area, body);
  const auto [smallest, largest] = std::minmax_element(result.shares.begin(), result.shares.end());
  EXPECT_NEAR(std::accumulate(result.shares.begin(), result.shares.end(), 0.0), 1.0, 1e-12);
  EXPECT_NEAR(*smallest * 44.0, 0.2, 1e-9);
  EXPECT_LT(*largest * 44.0, 10.0);
  const double rest = result.shares[0] + result.shares[1] + result.shares[2] + result.shares[3];
  EXPECT_NEAR(rest, 1.0 - 40.0 * 0.2 / 44.0, 1e-9);
}

/// A third of the area around the hub of a wheel would be 14 times the mean.
TEST(MassFractions, areaOfAHubIsBounded) {
  TriangleMesh wheel;
  wheel.positions.push_back({0, 0, 0});
  for (std::uint32_t i = 0; i < 40; ++i) {
    wheel.positions.push_back({std::cos(0.15 * i), std::sin(0.15 * i), 0});
    if (i > 0) wheel.triangles.push_back({0, i, i + 1});
  }
  wheel.triangles.push_back({0, 40, 1});
  for (const MassRule rule : {MassRule::Area, MassRule::Moments}) {
    const MassFractions result = shares(rule, welded(wheel));
    EXPECT_NEAR(result.shares[0] * 41.0, 10.0, 1e-9);
    EXPECT_NEAR(std::accumulate(result.shares.begin(), result.shares.end(), 0.0), 1.0, 1e-12);
  }
}

TEST(MassFractions, momentsAreMatchedWhereThePointsAllowIt) {
  struct Case {
    const char* name;
    WeldedMesh mesh;
  };
  const Case cases[] = {{"cube", withInnerPoints(small_meshes::cube(4), 0.2, 0.5)},
                        {"icosphere", withInnerPoints(small_meshes::icosphere(2), 0.4, 1.0)},
                        {"L", welded(test_shapes::lShape())},
                        {"cylinder", withInnerPoints(test_shapes::cylinder(), 0.2, 0.5)},
                        {"torus", welded(test_shapes::torus())},
                        {"figure", welded(test_shapes::figure())},
                        {"rabbit", withInnerPoints(test_shapes::rabbit(0.03), 0.1, 0.5)},
                        {"noise sphere", withInnerPoints(test_shapes::noiseSphere(2), 0.2, 0.7)}};
  for (const Case& c : cases) {
    SCOPED_TRACE(c.name);
    const MassFractions result = shares(MassRule::Moments, c.mesh);
    expectValid(result, c.mesh.points.size());
    EXPECT_LT(result.centreError, 1e-8);  // the solver stops at 1e-10, for moments of the order of 1
    EXPECT_LT(result.inertiaError, 1e-8);
  }
}

/// The distance from the origin must not matter: moments are about the centre of the solid.
TEST(MassFractions, farFromTheOrigin) {
  WeldedMesh mesh = welded(test_shapes::lShape());
  const MassFractions reference = shares(MassRule::Moments, mesh);
  for (Vector3d& p : mesh.points) p += Vector3d(300, -200, 100);
  const MassFractions moved = shares(MassRule::Moments, mesh);
  EXPECT_LT(moved.inertiaError, 1e-8);
  for (std::size_t i = 0; i < reference.shares.size(); ++i)
    EXPECT_NEAR(moved.shares[i], reference.shares[i], 1e-8);
}

/// All points are at the same distance from the centre. So the trace of the second moments is fixed: 5/3 of a
/// ball's. Only mass and centre can be matched.
TEST(MassFractions, momentsOfAHollowSphere) {
  const MassFractions result = shares(MassRule::Moments, welded(small_meshes::icosphere(2)));
  expectValid(result, 162);
  EXPECT_LT(result.centreError, 1e-8);
  EXPECT_NEAR(result.inertiaError, 5.0 / 3.0 - 1.0, 0.05);  // 0.05: the polyhedron is not exactly a ball
}

/// Proof that no mass fractions match, and whether the points or the bounds are the reason.
TEST(MassFractions, provesThatThereIsNoSolution) {
  const MassFractions hollow = shares(MassRule::Moments, welded(small_meshes::icosphere(2)));
  // the trace of the second moments is 1 for the ball and 5/3 for all mass fractions; the corners of the
  // polyhedron are a little farther from the centre
  EXPECT_GT(hollow.leastMisfit, 0.6 / std::sqrt(3.0) - 0.1);
  EXPECT_GT(hollow.leastMisfitAnyMass, 0.6 / std::sqrt(3.0) - 0.1) << "no lighter points would help";
  const MassFractions cube = shares(MassRule::Moments, welded(small_meshes::cube(4)));
  EXPECT_GT(cube.leastMisfit, 0.01);
  EXPECT_EQ(cube.leastMisfitAnyMass, 0.0) << "only the bounds on the shares stand against it";
  const MassFractions filled =
      shares(MassRule::Moments, withInnerPoints(small_meshes::icosphere(2), 0.4, 1.0));
  EXPECT_EQ(filled.leastMisfit, 0.0);
  EXPECT_LT(filled.inertiaError, 1e-8) << "points inside make it solvable";
}

/// The bodies of material mode have points inside the mesh.
TEST(MassFractions, momentsAreMatchedByTheBodiesOfMaterialMode) {
  for (const TriangleMesh& mesh : {small_meshes::cube(1), small_meshes::icosphere(2), test_shapes::cylinder(),
                                   test_shapes::noiseSphere(2)}) {
    const auto network = *limber::buildMaterialNetwork(mesh);
    const MassFractions result =
        limber::test::shareMass(MassRule::Moments, network->restPoints, network->surface);
    expectValid(result, network->restPoints.size());
    EXPECT_EQ(result.leastMisfit, 0.0);
    EXPECT_LT(result.centreError, 1e-8);
    EXPECT_LT(result.inertiaError, 1e-8);
  }
}

TEST(MassFractions, heavyPointsOfTheSurfaceAreBounded) {
  for (const TriangleMesh& mesh : {small_meshes::cube(4), test_shapes::noiseSphere(3)}) {
    const WeldedMesh body = welded(mesh);
    const MassFractions equal = shares(MassRule::Equal, body), result = shares(MassRule::Moments, body);
    expectValid(result, body.points.size());
    EXPECT_LE(*std::max_element(result.shares.begin(), result.shares.end()) * double(body.points.size()),
              10.01);
    EXPECT_LT(result.inertiaError, 0.4 * equal.inertiaError) << "better, if not exact";
    EXPECT_LT(result.centreError, 1e-5);
  }
}

TEST(MassFractions, openSurfacesHaveNoSolid) {
  const WeldedMesh sheet = welded(small_meshes::singleTriangle());
  const MassFractions result = shares(MassRule::Moments, sheet);
  EXPECT_EQ(result.shares, shares(MassRule::Area, sheet).shares);
  EXPECT_TRUE(std::isnan(result.centreError));
  EXPECT_TRUE(std::isnan(result.inertiaError));
}
