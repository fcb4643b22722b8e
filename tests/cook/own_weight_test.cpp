// SPDX-License-Identifier: Zlib
#include "cook/own_weight.h"

#include "support/network_shapes.h"
#include "support/networks.h"

#include <gtest/gtest.h>

#include <cmath>

using limber::leastStiffness;
using limber::SoftBodySettings;
using limber::SpringNetwork;
using network_shapes::bare;

namespace {

/// The greatest  m g / (k L)  that the network carries.
double loadLimit(const SpringNetwork& network, double volumeModulus) {
  SoftBodySettings settings;
  settings.totalMass = static_cast<double>(network.restPoints.size());
  settings.volumeModulus = volumeModulus;
  return 1.0 / leastStiffness(network, settings, 1.0);
}

}  // namespace

TEST(LeastStiffness, loadLimitsOfTheNotes) {
  // Measured there with other friction and damping on a coarse grid of masses; here they move the limits by
  // 15 %.
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
  EXPECT_GT(loadLimit(cube, -1.0), 2.0 * loadLimit(cube, 0.0));
}

TEST(LeastStiffness, tellsBodiesApart) {
  // a column of tetrahedra carries on its edges; a box whose faces have points within sags at once
  EXPECT_GT(loadLimit(*bare(network_shapes::cube8Tetrahedral()), -1.0),
            100.0 * loadLimit(*bare(network_shapes::cube26()), -1.0));
}

TEST(LeastStiffness, isProportionalToWeightOverSize) {
  const SpringNetwork cube = *limber::test::fullCubeNetwork();
  SoftBodySettings settings;
  const double at = leastStiffness(cube, settings, 9.81);
  settings.totalMass *= 3.0;
  EXPECT_NEAR(leastStiffness(cube, settings, 9.81), 3.0 * at, 1e-9 * at);
  settings.scale *= 2.0;
  EXPECT_NEAR(leastStiffness(cube, settings, 9.81), 1.5 * at, 1e-9 * at);
  EXPECT_NEAR(leastStiffness(cube, settings, 1.0), 1.5 / 9.81 * at, 1e-9 * at);
  settings.extensionStiffness = settings.compressionStiffness = 7.0;
  EXPECT_NEAR(leastStiffness(cube, settings, 1.0), 1.5 / 9.81 * at, 1e-9 * at);
}

TEST(LeastStiffness, limpBodiesCannotStand) {
  // links hanging upwards, and nothing at all
  EXPECT_EQ(leastStiffness(*limber::test::chainNetwork(4), {}, 9.81), HUGE_VAL);
  EXPECT_EQ(leastStiffness(*limber::test::cubeNetwork(), {}, 0.0), 0.0);
  EXPECT_EQ(leastStiffness(SpringNetwork{}, {}, 9.81), 0.0);
}
