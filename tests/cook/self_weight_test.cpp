// SPDX-License-Identifier: Zlib
#include "analysis/analysis.h"

#include "support/network_shapes.h"
#include "support/networks.h"

#include <limber/network_builder.h>

#include <gtest/gtest.h>

#include <cmath>
#include <optional>

using limber::minStiffness;
using limber::SoftBodySettings;
using limber::SpringNetwork;
using network_shapes::bare;

namespace {

/// Returns the largest m g / (k L) that the network carries.
double loadLimit(const SpringNetwork& network, std::optional<double> volumeModulus = {}) {
  SoftBodySettings settings;
  settings.totalMass = static_cast<double>(network.restPoints.size());
  settings.volumeModulus = volumeModulus;
  return 1.0 / minStiffness(network, settings, 1.0).value();
}

}  // namespace

TEST(LeastStiffness, loadLimitsOfTheNotes) {
  // The reference values were measured with other friction and damping on a coarse grid of masses; these
  // change the limits by 15 %.
  const struct {
    double found, notes;
  } rows[] = {{loadLimit(*bare(network_shapes::cube8()), 0.0), 0.050},
              {loadLimit(*limber::test::cubeNetwork(), 0.0), 0.32},
              {loadLimit(*limber::test::fullCubeNetwork(), 0.0), 0.49}};
  for (const auto& row : rows) {
    EXPECT_LT(row.found, 1.35 * row.notes);
    EXPECT_GT(row.found, row.notes / 1.35);
  }
}

TEST(LeastStiffness, volumeCarries) {
  const SpringNetwork cube = *limber::test::closedCubeNetwork();
  EXPECT_GT(loadLimit(cube), 2.0 * loadLimit(cube, 0.0));
}

TEST(LeastStiffness, tellsBodiesApart) {
  // a column of tetrahedra is carried by its edges; a box with points inside its faces collapses at once
  EXPECT_GT(loadLimit(*bare(network_shapes::cube8Tetrahedral())),
            100.0 * loadLimit(*bare(network_shapes::cube26())));
}

TEST(LeastStiffness, aBodyThatTopplesHasNotCollapsed) {
  // it leans so far that its centre of mass is not above its base: it falls over under any load
  SpringNetwork leaning = *limber::test::fullCubeNetwork();
  for (Eigen::Vector3d& p : leaning.restPoints) p = {0.3 * p.x() + 1.5 * p.y(), 2.0 * p.y(), 0.6 * p.z()};
  EXPECT_TRUE(std::isfinite(minStiffness(leaning, SoftBodySettings(), 9.81).value()));
}

TEST(LeastStiffness, isProportionalToWeightOverSize) {
  const SpringNetwork cube = *limber::test::fullCubeNetwork();
  SoftBodySettings settings;
  const double reference = minStiffness(cube, settings, 9.81).value();
  settings.totalMass *= 3.0;
  EXPECT_NEAR(minStiffness(cube, settings, 9.81).value(), 3.0 * reference, 1e-9 * reference);
  settings.scale *= 2.0;
  EXPECT_NEAR(minStiffness(cube, settings, 9.81).value(), 1.5 * reference, 1e-9 * reference);
  EXPECT_NEAR(minStiffness(cube, settings, 1.0).value(), 1.5 / 9.81 * reference, 1e-9 * reference);
  settings.extensionStiffness = settings.compressionStiffness = 7.0;
  EXPECT_NEAR(minStiffness(cube, settings, 1.0).value(), 1.5 / 9.81 * reference, 1e-9 * reference);
}

limber::TriangleMesh twoCubes(const limber::TriangleMesh& upper) {
  limber::TriangleMesh both = network_shapes::cube8();
  const auto first = static_cast<std::uint32_t>(both.positions.size());
  for (const Eigen::Vector3d& p : upper.positions) both.positions.push_back(p + Eigen::Vector3d(0, 9, 0));
  for (const limber::Triangle& t : upper.triangles)
    both.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
  return both;
}

/// Each piece stands on the ground: a piece in the air does not fall, and its size is not measured relative
/// to the distance to the other piece.
TEST(LeastStiffness, ofPiecesIsThatOfTheWorst) {
  SoftBodySettings settings;
  const auto leastOf = [&](const limber::TriangleMesh& mesh, double mass) {
    settings.totalMass = mass;
    return minStiffness(*bare(mesh), settings, 9.81).value();
  };
  const double one = leastOf(network_shapes::cube8(), 1.0);
  EXPECT_NEAR(leastOf(twoCubes(network_shapes::cube8()), 2.0), one, 1e-6 * one);
  const double weak = leastOf(network_shapes::cube26(), 26.0);
  ASSERT_GT(weak, 2.0 * leastOf(network_shapes::cube8(), 8.0));
  EXPECT_GT(leastOf(twoCubes(network_shapes::cube26()), 34.0), 0.5 * weak);
}

TEST(LeastStiffness, ofAMaterialKeepsItsTetrahedra) {
  limber::MaterialMesh coarse;
  coarse.points = 60;
  const SpringNetwork cube = **buildMaterialNetwork(network_shapes::cube8(), coarse);
  SpringNetwork springs = cube;
  springs.tetrahedra.clear();
  springs.surface.clear();
  EXPECT_GT(loadLimit(cube), 1.2 * loadLimit(springs));
}

TEST(LeastStiffness, endsWhenAskedOrWhenStepsAreTooShort) {
  int calls = 0;
  const auto endAtThird = [&](const char*, double) { return ++calls < 3; };
  EXPECT_FALSE(minStiffness(*limber::test::cubeNetwork(), {}, 9.81, endAtThird).has_value());
  EXPECT_EQ(calls, 3);
  for (const double scale : {1e12, 1e300}) {
    SpringNetwork cube = *limber::test::cubeNetwork();
    cube.springs[3].stiffnessScale = scale;
    EXPECT_FALSE(minStiffness(cube, {}, 9.81).has_value());
  }
}

TEST(LeastStiffness, limpBodiesCannotStand) {
  // a chain that stands upright, and a network without points
  EXPECT_EQ(minStiffness(*limber::test::chainNetwork(4), {}, 9.81), HUGE_VAL);
  EXPECT_EQ(minStiffness(*limber::test::cubeNetwork(), {}, 0.0), 0.0);
  EXPECT_EQ(minStiffness(SpringNetwork{}, {}, 9.81), 0.0);
}
