// SPDX-License-Identifier: Zlib
// Constants that a given number of substeps resolves.
#include "solver/stepping_choice.h"

#include "mesh/random.h"
#include "support/networks.h"
#include "support/stepped_body.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace limber {
namespace {

ElasticConstants constantsOf(const test::SteppedTestBody& body) {
  return {body.springs.original, body.volumes.constants, body.tetrahedra.constants};
}

/// rad^2/s^2, of the body at its present positions with these constants.
double fastestSquared(test::SteppedTestBody& body, const ElasticConstants& constants) {
  body.springs.original = constants.springs;
  body.volumes.constants = constants.volumes;
  body.tetrahedra.constants = constants.tetrahedra;
  return fastestOscillationSquared(body.springs, body.volumes, body.tetrahedra, body.state, 1e-4);
}

SharedNetwork uneven(const SharedNetwork& network) {
  auto copy = std::make_shared<SpringNetwork>(*network);
  Random dice(5);
  for (NetworkSpring& spring : copy->springs) spring.stiffnessScale = std::pow(10.0, 4.0 * dice.uniform());
  return copy;
}

std::vector<SharedNetwork> networks() {
  return {test::pairNetwork(),
          test::chainNetwork(16),
          uneven(test::chainNetwork(16)),
          uneven(test::fullCubeNetwork()),
          test::closedCubeNetwork(),
          test::tetrahedralCubeNetwork(),
          uneven(test::tetrahedralCubeNetwork())};
}

TEST(Softening, boundsTheFastestOscillation) {
  for (const SharedNetwork& network : networks()) {
    test::SteppedTestBody body(network, 1e6, 0.0);
    body.state.inverseMass.col(0).setConstant(0.3);  // one heavy point
    const Points rest = body.state.position;
    const ElasticConstants full = constantsOf(body);
    const double exact = fastestSquared(body, full);
    for (const double share : {0.5, 1e-2, 1e-6}) {
      const SoftenedConstants soft = softened(full, rest, body.state.inverseMass, share * exact);
      EXPECT_LE(fastestSquared(body, soft.constants), share * exact);
      EXPECT_LE(soft.share, 1.0);
    }
  }
}

TEST(Softening, boundsSpringsAtAnyDeformation) {
  Random dice(7);
  for (const SharedNetwork& network : networks()) {
    test::SteppedTestBody body(network, 1e6, 0.0);
    const ElasticConstants springs{body.springs.original, {}, {}};
    const Points rest = body.state.position;
    const double largest = 1e-3 * fastestSquared(body, springs);
    const SoftenedConstants soft = softened(springs, rest, body.state.inverseMass, largest);
    for (int i = 0; i < 20; ++i) {
      body.state.position =
          rest + 2.0 * Points::NullaryExpr(3, rest.cols(), [&] { return dice.uniform() - 0.5; });
      EXPECT_LE(fastestSquared(body, soft.constants), largest);
    }
  }
}

TEST(Softening, leavesLittleUnused) {
  // The graph's eigenvalue is that of springs which are as stiff across as along: in these networks up to 2.5
  // times that of the springs, which are in several directions.
  for (const SharedNetwork& network :
       {test::pairNetwork(), test::chainNetwork(16), test::fullCubeNetwork()}) {
    test::SteppedTestBody body(network, 1e6, 0.0);
    const ElasticConstants springs{body.springs.original, {}, {}};
    const Points rest = body.state.position;
    const double largest = 1e-3 * fastestSquared(body, springs);
    const SoftenedConstants soft = softened(springs, rest, body.state.inverseMass, largest);
    EXPECT_GT(fastestSquared(body, soft.constants), largest / 2.5);
  }
}

TEST(Softening, leavesWhatIsSlowEnough) {
  test::SteppedTestBody body(uneven(test::chainNetwork(16)), 1e3, 0.0);
  const ElasticConstants full = constantsOf(body);
  const Points rest = body.state.position;
  const SoftenedConstants all = softened(full, rest, body.state.inverseMass, 1e12);
  EXPECT_EQ(all.share, 1.0);
  EXPECT_EQ(&*all.constants.springs, &*full.springs);
  const SoftenedConstants some = softened(full, rest, body.state.inverseMass, 1e6);
  EXPECT_LT(some.share, 1.0);
  const auto &k = some.constants.springs->extensionStiffness, &original = full.springs->extensionStiffness;
  const auto i = std::min_element(original.begin(), original.end()) - original.begin();
  EXPECT_EQ(k[static_cast<std::size_t>(i)], original[static_cast<std::size_t>(i)]);
}

TEST(Softening, keepsTheRatioOfVolumeAndPressure) {
  test::SteppedTestBody body(test::closedCubeNetwork(), 1e6, 0.0);
  VolumeConstants gas = *body.volumes.constants;
  gas.gasPressure = 0.03 * gas.modulus, gas.ambient = 0.02 * gas.modulus;
  const ElasticConstants full{body.springs.original, SharedConstants<VolumeConstants>(gas), {}};
  const SoftenedConstants soft = softened(full, body.state.position, body.state.inverseMass, 1e4);
  EXPECT_LT(soft.share, 1e-3);
  const VolumeConstants& left = *soft.constants.volumes;
  EXPECT_NEAR(left.gasPressure, 0.03 * left.modulus, 1e-12 * left.modulus);
  EXPECT_NEAR(left.ambient, 0.02 * left.modulus, 1e-12 * left.modulus);
}

TEST(Softening, ofAStiffVolumeLeavesSlowSprings) {
  test::SteppedTestBody body(test::closedCubeNetwork(), 10.0, 0.0);
  VolumeConstants stiff = *body.volumes.constants;
  stiff.modulus = 1e9;
  const ElasticConstants full{body.springs.original, SharedConstants<VolumeConstants>(stiff), {}};
  const double largest = 10.0 * fastestSquared(body, {full.springs, {}, {}});
  const SoftenedConstants soft = softened(full, body.state.position, body.state.inverseMass, largest);
  EXPECT_LT(soft.share, 1e-3);
  EXPECT_EQ(&*soft.constants.springs, &*full.springs);
  EXPECT_LE(fastestSquared(body, soft.constants), largest);
}

TEST(SharedSoftening, isSharedByBodiesWithEqualMasses) {
  test::SteppedTestBody body(test::cubeNetwork(), 1e6, 0.0);
  const Points rest = body.state.position;
  Points heavy = body.state.inverseMass;
  heavy.col(0).setConstant(0.1);
  SharedSoftening shared;
  const auto once = softened(shared, constantsOf(body), rest, body.state.inverseMass, 1e4);
  EXPECT_EQ(softened(shared, constantsOf(body), rest, body.state.inverseMass, 1e4), once);
  EXPECT_NE(softened(shared, constantsOf(body), rest, body.state.inverseMass, 2e4), once);
  EXPECT_NE(softened(shared, constantsOf(body), rest, heavy, 1e4), once);
}

}  // namespace
}  // namespace limber
