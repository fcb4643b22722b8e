// SPDX-License-Identifier: Zlib
// Measured elasticity against closed forms.
#include "cook/elastic_moduli.h"
#include "cook/fourth_degree.h"
#include "support/networks.h"
#include "support/small_meshes.h"

#include <gtest/gtest.h>

#include <cmath>

namespace limber {
namespace {

TEST(ElasticModuli, ofABarOfSpringsAreThoseOfTheSprings) {
  // the edges of the unit cube alone carry stress along the axes: E = 4 k L / A = 4 k per edge length; the
  // face diagonals of the network, two a face of k, are what holds it against shear
  const SharedNetwork cube = test::closedCubeNetwork();
  const ElasticModuli once = measureModuli({*cube, 1000.0}), twice = measureModuli({*cube, 2000.0});
  EXPECT_NEAR(twice.youngsModulus / once.youngsModulus, 2.0, 1e-9) << "linear in the constant";
  EXPECT_NEAR(twice.poissonRatio, once.poissonRatio, 1e-9);
  const ElasticModuli large = measureModuli({*cube, 1000.0, 0.0, Eigen::Vector3d::Constant(2.0)});
  EXPECT_NEAR(large.youngsModulus / once.youngsModulus, 0.5, 1e-6) << "the same force on four times the area";
}

/// Uniform pressure p on the cube's corners: p / 4 along each edge direction at each corner. By symmetry all
/// lengths shrink alike by e; the energy is  e^2/2 k sum L^2 = e^2/2 k (12 + 12 * 2)  and  9 K e^2 V / 2.
TEST(ElasticModuli, bulkModulusOfTheCubeIsExact) {
  const SharedNetwork cube = test::closedCubeNetwork();
  EXPECT_NEAR(measureModuli({*cube, 1000.0}).bulkModulus, 1000.0 * 36.0 / 9.0, 1e-3);
  EXPECT_NEAR(measureModuli({*cube, 1000.0, 500.0}).bulkModulus, 4500.0, 1e-3)
      << "the modulus of the surface's volume adds to it";
}

TEST(ElasticModuli, ofABodyThatFallsApartAreNothing) {
  SpringNetwork loose = *test::closedCubeNetwork();
  loose.springs.resize(6);
  EXPECT_LT(measureModuli({loose, 1000.0}).youngsModuli[0], 1.0);
}

TEST(ElasticModuli, openingTheCubeAcrossTwoFacesIsItsStretching) {
  // four corners pulled along x by F/4 each: with diagonals in all faces more than the 4 edges' 4 k resist
  const SharedNetwork cube = test::closedCubeNetwork();
  const double stiffness = openingStiffness({*cube, 1000.0}, {-0.5, 0, 0}, {0.5, 0, 0}, 0.75);
  EXPECT_GT(stiffness, 4000.0);
  EXPECT_LT(stiffness, 12000.0) << "all springs that go along x, unbent";
  EXPECT_EQ(openingStiffness({*cube, 1000.0}, {-0.5, 0, 0}, {9, 0, 0}, 0.75), 0.0);
}

TEST(FourthDegree, knowsIsotropyAndLengths) {
  const FourthDegree n = fourthPower(Eigen::Vector3d(1, -2, 2) / 3.0);
  EXPECT_NEAR(n.squaredNorm(), 1.0, 1e-15);
  EXPECT_NEAR(n.dot(fourthPower({1, 0, 0})), std::pow(1.0 / 3.0, 4), 1e-15) << "(m . n)^4";
  // along any direction C_nnnn = lambda + 2 mu = 1.2
  EXPECT_NEAR(n.dot(isotropicElasticity()), 1.2, 1e-15);
}

TEST(FourthDegree, takesTheSymmetricPartOfAnElasticity) {
  Eigen::Matrix<double, 6, 6> c = Eigen::Matrix<double, 6, 6>::Zero();
  c.topLeftCorner<3, 3>().setConstant(0.4);
  c.diagonal() << 1.2, 1.2, 1.2, 0.4, 0.4, 0.4;
  EXPECT_NEAR((symmetricPart(c) - isotropicElasticity()).norm(), 0.0, 1e-15);
}

}  // namespace
}  // namespace limber
