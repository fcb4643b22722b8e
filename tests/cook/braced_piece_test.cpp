// SPDX-License-Identifier: Zlib
// The choice of braces among many pairs.
#include "network/bracing.h"

#include "mesh/random.h"
#include "network/modes.h"
#include "support/network_shapes.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace limber {
namespace {

BracedPiece pieceOf(const TriangleMesh& mesh) {
  SpringNetwork network = *network_shapes::bare(mesh);
  InsideChords chords(network.restPoints, network.surface, uniqueEdges(network.surface));
  return {std::move(network), std::move(chords), 0.3, 1000, {}};
}

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
    if (sum <= largest || !piece.chords.allowed(a, b)) continue;
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
