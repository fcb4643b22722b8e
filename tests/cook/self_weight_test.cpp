// SPDX-License-Identifier: Zlib
#include "analysis/analysis.h"

#include "support/network_shapes.h"
#include "support/networks.h"
#include "support/small_meshes.h"

#include <limber/network_builder.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>

using limber::SoftBodySettings;
using limber::SpringNetwork;
using limber::standingStiffness;
using network_shapes::bare;

namespace {

/// Returns the m g / (k L) under which the network stands at 90 % of its height.
double loadLimit(const SpringNetwork& network, std::optional<double> volumeModulus = {}) {
  SoftBodySettings settings;
  settings.totalMass = static_cast<double>(network.restPoints.size());
  settings.volumeModulus = volumeModulus;
  return 1.0 / standingStiffness(network, settings, 1.0).value();
}

}  // namespace

TEST(StandingStiffness, volumeCarries) {
  const SpringNetwork cube = *limber::test::closedCubeNetwork();
  EXPECT_GT(loadLimit(cube), 1.2 * loadLimit(cube, 0.0));
}

TEST(StandingStiffness, tellsBodiesApart) {
  // a column of tetrahedra is carried by its edges; a box with points inside its faces is soft there
  EXPECT_GT(loadLimit(*bare(network_shapes::cube8Tetrahedral())),
            30.0 * loadLimit(*bare(network_shapes::cube26())));
}

TEST(StandingStiffness, aBodyThatTopplesHasNotCollapsed) {
  // it leans so far that its centre of mass is not above its base: it falls over under any load
  SpringNetwork leaning = *limber::test::fullCubeNetwork();
  for (Eigen::Vector3d& p : leaning.restPoints) p = {0.3 * p.x() + 1.5 * p.y(), 2.0 * p.y(), 0.6 * p.z()};
  EXPECT_TRUE(std::isfinite(standingStiffness(leaning, SoftBodySettings(), 9.81).value()));
}

TEST(StandingStiffness, isProportionalToWeightOverSize) {
  const SpringNetwork cube = *limber::test::fullCubeNetwork();
  SoftBodySettings settings;
  const double reference = standingStiffness(cube, settings, 9.81).value();
  settings.totalMass *= 3.0;
  EXPECT_NEAR(standingStiffness(cube, settings, 9.81).value(), 3.0 * reference, 1e-9 * reference);
  settings.scale *= 2.0;
  EXPECT_NEAR(standingStiffness(cube, settings, 9.81).value(), 1.5 * reference, 1e-9 * reference);
  EXPECT_NEAR(standingStiffness(cube, settings, 1.0).value(), 1.5 / 9.81 * reference, 1e-9 * reference);
  settings.extensionStiffness = settings.compressionStiffness = 7.0;
  EXPECT_NEAR(standingStiffness(cube, settings, 1.0).value(), 1.5 / 9.81 * reference, 1e-9 * reference);
}

limber::TriangleMesh twoCubes(const limber::TriangleMesh& upper) {
  return small_meshes::joined(network_shapes::cube8(), small_meshes::moved(upper, {0, 9, 0}));
}

/// Each piece stands on the ground: a piece in the air does not fall, and its size is not measured relative
/// to the distance to the other piece.
TEST(StandingStiffness, ofPiecesIsThatOfTheWorst) {
  SoftBodySettings settings;
  const auto leastOf = [&](const limber::TriangleMesh& mesh, double mass) {
    settings.totalMass = mass;
    return standingStiffness(*bare(mesh), settings, 9.81).value();
  };
  const double one = leastOf(network_shapes::cube8(), 1.0);
  EXPECT_NEAR(leastOf(twoCubes(network_shapes::cube8()), 2.0), one, 1e-6 * one);
  const double weak = leastOf(network_shapes::cube26(), 26.0);
  ASSERT_GT(weak, 2.0 * leastOf(network_shapes::cube8(), 8.0));
  EXPECT_GT(leastOf(twoCubes(network_shapes::cube26()), 34.0), 0.5 * weak);
}

TEST(StandingStiffness, ofAMaterialKeepsItsTetrahedra) {
  limber::MaterialMesh coarse;
  coarse.points = 60;
  const SpringNetwork cube = **buildMaterialNetwork(network_shapes::cube8(), coarse);
  SpringNetwork springs = cube;
  springs.tetrahedra.clear();
  springs.surface.clear();
  EXPECT_GT(loadLimit(cube), 1.1 * loadLimit(springs));
}

TEST(StandingStiffness, endsWhenAskedOrWhenStepsAreTooShort) {
  int calls = 0;
  const auto endAtThird = [&](const char*, double) { return ++calls < 3; };
  EXPECT_FALSE(standingStiffness(*limber::test::cubeNetwork(), {}, 9.81, endAtThird).has_value());
  EXPECT_EQ(calls, 3);
  for (const double scale : {1e12, 1e300}) {
    SpringNetwork cube = *limber::test::cubeNetwork();
    cube.springs[3].stiffnessScale = scale;
    EXPECT_FALSE(standingStiffness(cube, {}, 9.81).has_value());
  }
}

TEST(StandingStiffness, limpBodiesCannotStand) {
  // a cube of its edges alone, and a network without points
  SpringNetwork frame = *limber::test::cubeNetwork();
  frame.springs.erase(std::remove_if(frame.springs.begin(), frame.springs.end(),
                                     [&](const limber::NetworkSpring& s) {
                                       return (frame.restPoints[s.a] - frame.restPoints[s.b]).norm() > 1.1;
                                     }),
                      frame.springs.end());
  ASSERT_EQ(frame.springs.size(), 12u);
  EXPECT_EQ(standingStiffness(frame, {}, 9.81), HUGE_VAL);
  EXPECT_EQ(standingStiffness(*limber::test::cubeNetwork(), {}, 0.0), 0.0);
  EXPECT_EQ(standingStiffness(SpringNetwork{}, {}, 9.81), 0.0);
}
