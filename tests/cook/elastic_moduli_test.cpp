// SPDX-License-Identifier: Zlib
// Measured elasticity, compared with closed forms.
#include "network/material.h"

#include "support/elastic_measures.h"
#include "support/networks.h"
#include "support/small_meshes.h"

#include <limber/network_builder.h>

#include <gtest/gtest.h>

#include <cmath>

namespace limber {
namespace {

/// 12 points on a sphere of radius 1, 30 springs.
SharedNetwork icosahedron() {
  NetworkSettings settings;
  settings.braces = BraceRule::None;
  settings.braceWeight = 1.0;
  return *buildNetwork(small_meshes::icosphere(0), settings);
}

const double kEdge = 4.0 / std::sqrt(10.0 + 2.0 * std::sqrt(5.0));
const double kVolume = 5.0 / 12.0 * (3.0 + std::sqrt(5.0)) * kEdge * kEdge * kEdge;

/// Under uniform pressure all edges shrink by the fraction e: the energy is  e^2/2 k sum L^2 = 9 K V e^2/2.
TEST(ElasticModuli, bulkModulusOfAnIcosahedronIsExact) {
  const SharedNetwork network = icosahedron();
  const double springs = 1000.0 * 30.0 * kEdge * kEdge / (9.0 * kVolume);
  // 1e-6: effect of the shift of the matrix
  EXPECT_NEAR(measureModuli({*network, 1000.0}).bulkModulus / springs, 1.0, 1e-6);
  EXPECT_NEAR(measureModuli({*network, 1000.0, 500.0}).bulkModulus / (springs + 500.0), 1.0, 1e-6)
      << "the modulus of the volume inside adds to it";
}

TEST(ElasticModuli, ofAnIcosahedronAreTheSameInAllDirections) {
  const SharedNetwork network = icosahedron();
  const ElasticModuli moduli = measureModuli({*network, 1000.0});
  EXPECT_NEAR(moduli.isotropy, 1.0, 1e-6);
  EXPECT_NEAR(moduli.youngsModulus, 3.0 * moduli.bulkModulus * (1.0 - 2.0 * moduli.poissonRatio),
              1e-5 * moduli.youngsModulus);
}

TEST(ElasticModuli, scaleWithTheSpringsAndTheSize) {
  const SharedNetwork cube = test::closedCubeNetwork();
  const ElasticModuli reference = measureModuli({*cube, 1000.0}), doubled = measureModuli({*cube, 2000.0});
  EXPECT_NEAR(doubled.youngsModulus / reference.youngsModulus, 2.0, 1e-9);
  EXPECT_NEAR(doubled.poissonRatio, reference.poissonRatio, 1e-9);
  const ElasticModuli large = measureModuli({*cube, 1000.0, 0.0, Eigen::Vector3d::Constant(2.0)});
  EXPECT_NEAR(large.youngsModulus / reference.youngsModulus, 0.5, 1e-6)
      << "twice the force on four times the area";
}

TEST(ElasticModuli, ofABodyThatFallsApartAreNothing) {
  SpringNetwork loose = *test::closedCubeNetwork();
  loose.springs.resize(6);
  EXPECT_LT(measureModuli({loose, 1000.0}).youngsModuli[0], 1.0);
}

TEST(ElasticModuli, openingTheCubeAcrossTwoFacesIsItsStretching) {
  // four corners are pulled along x by F/4 each: the diagonals of all faces add to the 4 k of the 4 edges
  const SharedNetwork cube = test::closedCubeNetwork();
  const double stiffness = test::openingStiffness({*cube, 1000.0}, {-0.5, 0, 0}, {0.5, 0, 0}, 0.75);
  EXPECT_GT(stiffness, 4000.0);
  EXPECT_LT(stiffness, 12000.0) << "all springs that go along x, unbent";
  EXPECT_EQ(test::openingStiffness({*cube, 1000.0}, {-0.5, 0, 0}, {9, 0, 0}, 0.75), 0.0);
}

/// A cube with all twelve edges and two diagonals of each face: by symmetry the six moduli are equal. They
/// scale as stresses do.
TEST(ElasticModuli, ofBendingAreTheSameAboutAllAxesOfACube) {
  const SharedNetwork cube = test::closedCubeNetwork();
  const auto bending = measureModuli({*cube, 1000.0}).bending;
  for (const BendingModulus& b : bending) {
    EXPECT_NEAR(b.modulus / bending[0].modulus, 1.0, 1e-6);
    EXPECT_NEAR(b.slenderness, 1.0, 1e-12);
  }
  const auto large = measureModuli({*cube, 1000.0, 0.0, Eigen::Vector3d::Constant(2.0)}).bending;
  EXPECT_NEAR(large[0].modulus / bending[0].modulus, 0.5, 1e-6) << "twice the force on four times the area";
}

/// The bending moduli of a homogeneous solid are its Young's modulus, for any shape and position.
TEST(ElasticModuli, ofBendingComeNearYoungsModulusOnAFineLattice) {
  MaterialMesh settings;
  settings.points = 4000;
  const SharedNetwork network = *buildMaterialNetwork(small_meshes::cube(1), settings);
  for (const BendingModulus& b : measureModuli({*network, network->stiffnessPerModulus}).bending)
    EXPECT_NEAR(b.modulus, 1.0, 0.06);
}

TEST(FourthDegree, knowsIsotropyAndLengths) {
  const FourthDegree n = fourthPower(Eigen::Vector3d(1, -2, 2) / 3.0);
  EXPECT_NEAR(n.squaredNorm(), 1.0, 1e-15);
  EXPECT_NEAR(n.dot(fourthPower({1, 0, 0})), std::pow(1.0 / 3.0, 4), 1e-15) << "(m . n)^4";
  // along any direction C_nnnn = lambda + 2 mu = 1.2
  EXPECT_NEAR(n.dot(isotropicElasticity()), 1.2, 1e-15);
}

}  // namespace
}  // namespace limber
