// SPDX-License-Identifier: Zlib
// The properties of BraceRule::Pipeline and TwoRing, on small shapes and few runs; bench/run networks tests
// large ones. The choice of braces among many pairs.
#include "network/bracing.h"

#include "analysis/analysis.h"
#include "mesh/random.h"
#include "mesh/triangle_bvh.h"
#include "network/material.h"
#include "network/stability.h"
#include "solver/volumes.h"
#include "support/elastic_measures.h"
#include "support/network_shapes.h"
#include "support/small_meshes.h"

#include <limber/network_builder.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <string>

namespace limber {
namespace {

SharedNetwork build(const TriangleMesh& mesh, const NetworkSettings& settings = {}) {
  Result<SharedNetwork> network = buildNetwork(mesh, settings);
  if (!network) {
    ADD_FAILURE() << network.error();
    return std::make_shared<SpringNetwork>();
  }
  EXPECT_EQ(validate(**network).error(), "");
  return *network;
}

std::vector<NetworkSpring> bracesOf(const SpringNetwork& network) {
  std::vector<NetworkSpring> braces;
  for (const NetworkSpring& s : network.springs)
    if (s.kind == SpringKind::Brace) braces.push_back(s);
  return braces;
}

std::vector<Edge> pairsOf(const std::vector<NetworkSpring>& springs) {
  std::vector<Edge> pairs;
  for (const NetworkSpring& s : springs) pairs.push_back({s.a, s.b});
  return pairs;
}

class Shapes : public testing::TestWithParam<network_shapes::NamedShape> {};

/// The runs use another seed than the bracing (1).
TEST_P(Shapes, comeBackWithAtMostOneBracePerPoint) {
  const SharedNetwork network = build(GetParam().make());
  EXPECT_LE(bracesOf(*network).size(), network->restPoints.size());
  for (std::size_t kind = 0; kind < kDeformations; ++kind)
    EXPECT_EQ(measureReturns(*network, static_cast<Deformation>(kind), 8, 4711).returned, 8u) << kind;
  const SmallDeformations small = smallDeformations(*network);
  EXPECT_EQ(small.mechanisms, 0u);
  EXPECT_GE(small.softest, minModeRatio(network->restPoints.size()) * small.stiffest);
}

TEST_P(Shapes, haveTheirBracesInside) {
  const SharedNetwork network = build(GetParam().make());
  const TriangleBvh surface(network->restPoints, network->surface);
  for (const NetworkSpring& s : bracesOf(*network)) {
    EXPECT_EQ(s.stiffnessScale, 0.5);
    EXPECT_TRUE(surface.staysInside(network->restPoints[s.a], network->restPoints[s.b], 1e-5))
        << s.a << ' ' << s.b;
  }
}

/// The ends of the arms of an L are pulled apart. The result is relative to the bulk modulus, with the volume
/// term. The same L of tetrahedra has 0.0090 m. Braces for modes that are already stiff enough would connect
/// the arms.
TEST(Pipeline, leavesTheArmsOfAnLFreeToOpen) {
  const SharedNetwork network = build(network_shapes::lshape90());
  ElasticBody body{*network};
  body.volumeModulus = networkModulus(*network, body.scale, body.stiffness, 5.0 / 27.0);
  const double opening = test::openingStiffness(body, {-0.5, 0.5, 0.0}, {0.5, -0.5, 0.0}, 0.3);
  EXPECT_LT(opening / measureModuli(body).bulkModulus, 1.5 * 0.0090);
}

INSTANTIATE_TEST_SUITE_P(Bracing, Shapes,
                         testing::Values(network_shapes::NamedShape{"cube26", network_shapes::cube26},
                                         network_shapes::NamedShape{"ico42", network_shapes::ico42},
                                         network_shapes::NamedShape{"cyl62", network_shapes::cyl62},
                                         network_shapes::NamedShape{"lshape90", network_shapes::lshape90}),
                         [](const auto& tested) { return std::string(tested.param.name); });

TEST(Bracing, isDeterministicAndSeeded) {
  NetworkSettings settings;
  const auto braces = [&] { return pairsOf(bracesOf(*build(network_shapes::tube60(), settings))); };
  const std::vector<Edge> first = braces();
  EXPECT_EQ(first, braces());
  settings.seed = 2;
  EXPECT_NE(first, braces());
  settings.maxBracesPerPoint = 0.7;
  EXPECT_EQ(braces().size(), 42u);
}

TEST(Bracing, turnsMeshesThatAreInsideOut) {
  const TriangleMesh mesh = network_shapes::ico42();
  const std::vector<Edge> expected = pairsOf(bracesOf(*build(mesh)));
  EXPECT_EQ(pairsOf(bracesOf(*build(small_meshes::inverted(mesh)))).size(), expected.size());
}

TEST(Bracing, keepsToTheCapAndTheWeight) {
  NetworkSettings settings;
  settings.maxBracesPerPoint = 0.25;
  settings.braceWeight = 0.5;
  const std::vector<NetworkSpring> braces = bracesOf(*build(network_shapes::ico42(), settings));
  EXPECT_EQ(braces.size(), 10u);  // 0.25 x 42
  for (const NetworkSpring& s : braces) EXPECT_EQ(s.stiffnessScale, 0.5);
}

TEST(Bracing, reportsProgressAndEndsEarly) {
  NetworkSettings settings;
  int calls = 0;
  settings.progress = [&](const char* what, double done) {
    EXPECT_NE(std::string(what), "");
    EXPECT_GE(done, 0.0);
    EXPECT_LE(done, 1.0);
    ++calls;
    return true;
  };
  build(network_shapes::cube26(), settings);
  EXPECT_GT(calls, 10);
  calls = 0;
  settings.progress = [&](const char*, double) { return ++calls < 3; };
  build(network_shapes::cube26(), settings);
  EXPECT_EQ(calls, 3) << "once told to end, it asks no more";
}

/// A round takes many seconds for thousands of points.
TEST(Bracing, asksForProgressWithinRounds) {
  NetworkSettings settings;
  std::set<double> rounds;
  std::size_t calls = 0;
  settings.progress = [&](const std::string& what, double done) {
    if (what != "bracing: soft modes") return what != "bracing: wrong shapes";
    rounds.insert(done);
    ++calls;
    return true;
  };
  build(network_shapes::cube98(), settings);
  EXPECT_GT(calls, 3 * rounds.size());
}

TEST(Bracing, endsWhenTheTimeIsOver) {
  NetworkSettings settings;
  settings.timeLimit = 1e-9;
  EXPECT_TRUE(bracesOf(*build(network_shapes::ico42(), settings)).empty());
}

TEST(Bracing, neverJoinsComponents) {
  const TriangleMesh cube = network_shapes::cube26();
  const TriangleMesh two =
      small_meshes::joined(cube, small_meshes::moved(network_shapes::ico42(), {1.6, 0, 0}));
  const std::size_t first = cube.positions.size();
  for (const BraceRule rule : {BraceRule::EqualLength, BraceRule::TwoRing, BraceRule::Pipeline}) {
    NetworkSettings settings;
    settings.braces = rule;
    const SharedNetwork network = build(two, settings);
    for (const NetworkSpring& s : network->springs) EXPECT_EQ(s.a < first, s.b < first);
    if (rule != BraceRule::Pipeline) continue;
    for (const Deformation kind : {Deformation::Squash, Deformation::Noise})
      EXPECT_EQ(measureReturns(*network, kind, 8, 4711).returned, 8u);
  }
}

TEST(Bracing, givesFlatAndOpenOnesTheTwoRing) {
  for (const TriangleMesh& mesh :
       {network_shapes::cloth100(), small_meshes::singleTriangle(), small_meshes::nonManifoldEdge()}) {
    NetworkSettings settings;
    const std::vector<Edge> braces = pairsOf(bracesOf(*build(mesh, settings)));
    settings.braces = BraceRule::TwoRing;
    EXPECT_EQ(braces, pairsOf(bracesOf(*build(mesh, settings))));
  }
}

TEST(Bracing, copesWithHolesAndFlippedTriangles) {
  TriangleMesh holed = network_shapes::ico42();
  holed.triangles.erase(holed.triangles.begin(), holed.triangles.begin() + 2);
  EXPECT_GT(bracesOf(*build(holed)).size(), 10u);
  build(small_meshes::flippedTriangle());
  const TriangleMesh ball = network_shapes::ico42();
  const TriangleMesh crossing = small_meshes::joined(ball, small_meshes::moved(ball, {0.4, 0, 0}));
  EXPECT_GT(bracesOf(*build(crossing)).size(), 40u);
}

TEST(TwoRing, joinsAllThatShareANeighbour) {
  NetworkSettings settings;
  settings.braces = BraceRule::TwoRing;
  // an icosahedron: from each point all others but the opposite one are within two edges, 5 of them within
  // one
  EXPECT_EQ(bracesOf(*build(small_meshes::icosphere(0), settings)).size(), 12u * 5u / 2u);
  EXPECT_EQ(bracesOf(*build(small_meshes::tetrahedron(), settings)).size(), 0u);
  SpringNetwork chain;
  chain.restPoints = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}};
  chain.springs = {{0, 1}, {1, 2}, {2, 3}};
  EXPECT_EQ(findTwoRingPairs(chain), (std::vector<Edge>{{0, 2}, {1, 3}}));
}

// --- the choice among many pairs ---------------------------------------------------------------------------

BracedPiece pieceOf(const TriangleMesh& mesh) { return {*network_shapes::bare(mesh), 0.3, 1000}; }

BraceChoice randomChoice(const BracedPiece& piece, std::size_t purposes) {
  BraceChoice choice(purposes, candidatePairs(piece, 100000, 1));
  Random random(1);
  for (float& x : choice.benefit.reshaped()) x = static_cast<float>(random.uniform());
  return choice;
}

Eigen::Index bestOfAll(BracedPiece& piece, const BraceChoice& choice, const Eigen::VectorXf& weights) {
  Eigen::Index best = -1;
  float largest = 0.0f;
  for (Eigen::Index i = 0; i < choice.benefit.cols(); ++i) {
    const auto [a, b] = choice.pairs[static_cast<std::size_t>(i)];
    const float sum = choice.benefit.col(i).dot(weights);
    if (sum <= largest || !piece.allows(a, b)) continue;
    best = i;
    largest = sum;
  }
  return best;
}

/// While the weights fall at different rates.
TEST(BraceChoice, givesTheBestOfAllEachTime) {
  BracedPiece piece = pieceOf(network_shapes::lshape90());
  BraceChoice choice = randomChoice(piece, 7);
  Eigen::VectorXf weights = Eigen::VectorXf::Ones(7);
  for (int i = 0; i < 60; ++i) {
    const Eigen::Index best = bestOfAll(piece, choice, weights);
    const Eigen::VectorXf benefits = addBest(piece, choice, weights);
    ASSERT_EQ(piece.braces.back(), choice.pairs[static_cast<std::size_t>(best)]) << i;
    weights.array() /= 1.0f + benefits.array();
  }
}

TEST(BraceChoice, endsWhenNothingIsOfUse) {
  BracedPiece piece = pieceOf(network_shapes::ico42());
  BraceChoice choice = randomChoice(piece, 2);
  EXPECT_EQ(addBest(piece, choice, Eigen::VectorXf::Zero(2)).size(), 0);
  EXPECT_TRUE(piece.braces.empty());
}

/// The eigenvalues of rough modes are not below those of the modes, and nearly equal for the softest.
TEST(RoughModes, areSoft) {
  const SharedNetwork network = network_shapes::bare(network_shapes::noise642());
  const Modes modes = softestModes(*network, 60), rough = roughModes(*network, 60);
  ASSERT_GE(rough.eigenvalues.size(), 60);
  for (Eigen::Index i = 0; i < 60; ++i) EXPECT_GE(rough.eigenvalues[i], 0.999 * modes.eigenvalues[i]) << i;
  for (Eigen::Index i = 0; i < 10; ++i) EXPECT_LE(rough.eigenvalues[i], 1.5 * modes.eigenvalues[i]) << i;
  EXPECT_LE(rough.eigenvalues[59], 10.0 * modes.eigenvalues[59]);
}

TEST(SoftModeBraces, goForLessOfManyPoints) {
  EXPECT_EQ(minModeRatio(8), 1e-3);
  EXPECT_EQ(minModeRatio(600), 1e-3);
  EXPECT_NEAR(minModeRatio(6000), 1e-4, 1e-12);
}

}  // namespace
}  // namespace limber
