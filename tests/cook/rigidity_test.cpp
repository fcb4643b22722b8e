// SPDX-License-Identifier: Zlib
#include "analysis/analysis.h"

#include "mesh/linear_algebra.h"
#include "mesh/random.h"
#include "mesh/surface.h"
#include "network/stability.h"
#include "support/network_shapes.h"
#include "support/networks.h"
#include "support/small_meshes.h"
#include "support/test_shapes.h"

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include <cmath>

using limber::kPi;
using limber::Modes;
using limber::product;
using limber::SharedNetwork;
using limber::SmallDeformations;
using limber::smallDeformations;
using limber::softestModes;
using limber::SpringNetwork;
using limber::transposedProduct;
using network_shapes::bare;

namespace {

struct Row {
  const char* name;
  SharedNetwork network;
  std::size_t rank, mechanisms, selfStresses;
  double softest, stiffest;  ///< 0: the mesh of the reference had other proportions
};

std::vector<Row> table() {
  using namespace network_shapes;
  return {{"cube8", bare(cube8()), 18, 0, 0, 0.31, 4.6},
          {"cube8, tetrahedral", bare(cube8Tetrahedral()), 18, 0, 0, 0.38, 5.2},
          {"cube26", bare(cube26()), 66, 6, 6, 0.19, 5.7},
          {"cube98", bare(cube98()), 234, 54, 54, 0.080, 6.3},
          {"ico42", bare(ico42()), 120, 0, 0, 0.17, 5.1},
          {"ico162", bare(ico162()), 480, 0, 0, 0.046, 5.8},
          {"ico642", bare(ico642()), 1920, 0, 0, 0.012, 6.0},
          {"torus128", bare(torus128()), 378, 0, 6, 2.5e-6, 6.8},
          {"hull60", bare(hull60()), 174, 0, 0, 0, 0},
          {"cyl62", bare(cyl62()), 178, 2, 2, 2.2e-3, 7.1},
          {"cyl60", bare(cyl60()), 174, 0, 0, 2.2e-3, 7.1},
          {"lshape90", bare(lshape90()), 228, 36, 36, 1.6e-3, 6.5},
          {"star162", bare(star162()), 480, 0, 0, 0, 0},
          {"noise162", bare(noise162()), 480, 0, 0, 0, 0},
          {"noise642", bare(noise642()), 1920, 0, 0, 0, 0},
          {"rabbit302", bare(rabbit302()), 900, 0, 0, 0, 0},
          {"cloth100", bare(cloth100()), 197, 97, 64, 0.073, 6.6},
          {"rope20", rope20(), 19, 36, 0, 0.025, 4.0},
          {"tube60", bare(tube60()), 174, 0, 0, 9.3e-4, 5.5}};
}

Eigen::VectorXd allEigenvalues(const SpringNetwork& network) {
  return limber::symmetricValues(limber::stiffnessMatrix(rigidityMatrix(network)));
}

}  // namespace

TEST(SmallDeformations, tableOfTheNotes) {
  for (const Row& row : table()) {
    SCOPED_TRACE(row.name);
    const SmallDeformations found = smallDeformations(*row.network);
    EXPECT_EQ(found.rank, row.rank);
    EXPECT_EQ(found.mechanisms, row.mechanisms);
    EXPECT_EQ(found.selfStresses, row.selfStresses);
    if (row.softest == 0.0) continue;
    // the table has two digits
    EXPECT_NEAR(found.softest, row.softest, 0.05 * row.softest);
    EXPECT_NEAR(found.stiffest, row.stiffest, 0.06);
  }
}

TEST(SmallDeformations, aChainIsAChain) {
  // Along its line a free chain of n points has the eigenvalues 2 - 2 cos(pi i / n), i = 1 ... n - 1; across
  // it all are 0.
  for (const int links : {1, 5, 300}) {
    const SmallDeformations found = smallDeformations(*limber::test::chainNetwork(links));
    const auto count = static_cast<std::size_t>(links);
    EXPECT_EQ(found.rank, count);
    EXPECT_EQ(found.mechanisms, 3 * (count + 1) - 5 - count);
    EXPECT_EQ(found.selfStresses, 0u);
    EXPECT_NEAR(found.softest, 2.0 - 2.0 * std::cos(kPi / (links + 1)), 1e-8);
    EXPECT_NEAR(found.stiffest, 2.0 + 2.0 * std::cos(kPi / (links + 1)), 1e-8);
  }
}

TEST(SmallDeformations, sizePlaceAndTurnDoNotMatter) {
  const SharedNetwork cube = bare(network_shapes::cube26());
  const SmallDeformations reference = smallDeformations(*cube);
  for (const double size : {1e-6, 1.0, 1e6}) {
    SpringNetwork moved = *cube;
    const Eigen::AngleAxisd rotation(0.7, Eigen::Vector3d(1, 2, 3).normalized());
    for (Eigen::Vector3d& p : moved.restPoints) p = size * (rotation * p + Eigen::Vector3d(3, -5, 8));
    const SmallDeformations found = smallDeformations(moved);
    EXPECT_EQ(found.mechanisms, reference.mechanisms);
    EXPECT_NEAR(found.softest, reference.softest, 1e-9);
    EXPECT_NEAR(found.stiffest, reference.stiffest, 1e-9);
  }
}

TEST(SmallDeformations, singlePrecisionDoesNotHideMechanisms) {
  SpringNetwork cube = *bare(network_shapes::cube98());
  const Eigen::AngleAxisd rotation(0.7, Eigen::Vector3d(1, 2, 3).normalized());
  for (Eigen::Vector3d& p : cube.restPoints) p = (rotation * p).cast<float>().cast<double>();
  EXPECT_EQ(smallDeformations(cube).mechanisms, 54u);
}

TEST(SmallDeformations, sparseIsAsGoodAsDense) {
  // 218 points with 150 mechanisms, and a braced body
  SpringNetwork braced = *bare(network_shapes::rabbit302());
  for (std::uint32_t i = 0; i < 151; i += 3)
    braced.springs.push_back({i, i + 151, limber::SpringKind::Brace, 0.3});
  for (const SpringNetwork& network : {*bare(small_meshes::cube(6)), braced}) {
    const Eigen::VectorXd all = allEigenvalues(network);
    const SmallDeformations found = smallDeformations(network);
    const auto soft = static_cast<Eigen::Index>(found.mechanisms + 6);
    EXPECT_LT(all[soft - 1], 1e-13);
    EXPECT_NEAR(found.softest / all[soft], 1.0, 1e-6);
    EXPECT_NEAR(found.stiffest / all[all.size() - 1], 1.0, 1e-6);
  }
  EXPECT_EQ(smallDeformations(*bare(small_meshes::cube(6))).mechanisms, 150u);
}

TEST(SmallDeformations, componentsMoveFreely) {
  SpringNetwork two = *bare(network_shapes::ico42());
  const SpringNetwork one = two;
  for (const Eigen::Vector3d& p : one.restPoints) two.restPoints.emplace_back(p + Eigen::Vector3d(5, 0, 0));
  for (const limber::NetworkSpring& s : one.springs) two.springs.push_back({s.a + 42, s.b + 42, s.kind, 1.0});
  EXPECT_EQ(smallDeformations(two).mechanisms, 6u);
}

TEST(SmallDeformations, nothingToDeform) {
  SpringNetwork network;
  EXPECT_EQ(smallDeformations(network).mechanisms, 0u);
  network.restPoints = {{1, 2, 3}};
  EXPECT_EQ(smallDeformations(network).mechanisms, 0u);
  network.restPoints.emplace_back(2, 2, 3);
  EXPECT_EQ(smallDeformations(network).mechanisms, 1u) << "two points that nothing joins";
}

TEST(SoftestModes, areTheEigenvectors) {
  // dense, sparse, with equal modes, with more mechanisms than requested modes, with very soft modes
  for (const SharedNetwork& network : {bare(network_shapes::cube98()), bare(network_shapes::ico162()),
                                       bare(network_shapes::lshape90()), bare(network_shapes::noise162()),
                                       bare(test_shapes::rabbit(0.066)), limber::test::chainNetwork(200)}) {
    const Eigen::MatrixXd stiffness = limber::stiffnessMatrix(rigidityMatrix(*network));
    const Eigen::MatrixXd rigid = limber::rigidMotions(network->restPoints);
    const Eigen::VectorXd all = allEigenvalues(*network).tail(stiffness.rows() - rigid.cols());
    const Modes modes = softestModes(*network, 30);
    ASSERT_EQ(modes.eigenvalues.size(), 30);
    const double stiffest = all[all.size() - 1];
    // the residuals are 1e-5 of the eigenvalues of the inverse
    EXPECT_LT((modes.eigenvalues - all.head(30)).cwiseAbs().maxCoeff(), 1e-7 * stiffest);
    EXPECT_LT((transposedProduct(modes.shapes, modes.shapes) - Eigen::MatrixXd::Identity(30, 30)).norm(),
              1e-9);
    EXPECT_LT(transposedProduct(rigid, modes.shapes).norm(), 1e-8);
    EXPECT_LT((product(stiffness, modes.shapes) - modes.shapes * modes.eigenvalues.asDiagonal()).norm(),
              1e-4 * stiffest);
  }
}

TEST(SoftestModes, allEqualOnesAreFound) {
  // 600 mechanisms, of which a Krylov space contains only a few at a time
  const SharedNetwork chain = limber::test::chainNetwork(300);
  const Modes modes = softestModes(*chain, 40);
  EXPECT_LT(modes.eigenvalues.maxCoeff(), 1e-12);
}

/// With stiffnesses of very different magnitude the iteration never converges and returns its best result.
TEST(SoftestModes, areModesEvenWhereTheyAreNotExact) {
  SpringNetwork uneven = *bare(network_shapes::ico162());
  limber::Random random(1);
  for (limber::NetworkSpring& s : uneven.springs) s.stiffnessScale = std::pow(1e12, random.uniform());
  for (const Eigen::Index count : {10, 30}) {
    const Eigen::MatrixXd shapes = softestModes(uneven, static_cast<std::size_t>(count)).shapes;
    ASSERT_EQ(shapes.cols(), count);
    EXPECT_LT((transposedProduct(shapes, shapes) - Eigen::MatrixXd::Identity(count, count)).norm(), 1e-8);
  }
}

TEST(SoftestModes, noMoreThanThereAre) {
  EXPECT_EQ(softestModes(*limber::test::pairNetwork(), 30).eigenvalues.size(), 1);
  EXPECT_NEAR(softestModes(*limber::test::pairNetwork(), 30).eigenvalues[0], 2.0, 1e-12);
  EXPECT_EQ(softestModes(*limber::test::cubeNetwork(), 1000).eigenvalues.size(), 18);
  EXPECT_EQ(softestModes(SpringNetwork{}, 3).eigenvalues.size(), 0);
  SpringNetwork dust;
  for (int i = 0; i < 200; ++i) dust.restPoints.emplace_back(i, i * i % 7, i * i % 11);
  EXPECT_EQ(softestModes(dust, 10).eigenvalues, Eigen::VectorXd::Zero(10));
}

TEST(SoftestModes, sameEveryTime) {
  const SharedNetwork ico = bare(network_shapes::ico642());
  EXPECT_EQ(softestModes(*ico, 10).shapes, softestModes(*ico, 10).shapes);
}
