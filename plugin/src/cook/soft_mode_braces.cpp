// SPDX-License-Identifier: Zlib
#include "cook/soft_mode_braces.h"

#include "cook/rigidity.h"
#include "cook/stiffness_matrix.h"
#include "solver/linear_algebra.h"

#include <algorithm>

namespace limber {
namespace {

constexpr double kLeastRatio = 1e-3;
/// The ratio of icospheres of n points without braces is 1.2/n (their edges alone are rigid).
constexpr double kLeastRatioTimesPoints = 0.6;

constexpr int kMostBraceRounds = 40;
constexpr std::size_t kLeastModes = 30, kMostModes = 150;  // looked at together
/// Of more points than this so many rough modes are looked at: fewer rounds, each in less time.
constexpr std::size_t kMany = 1000, kRoughModes = 300;
constexpr std::size_t kMostSoftCandidates = 100000;

/// Modes are braced somewhat beyond the goal: the estimate of their new stiffness leaves out that they give
/// way sideways. Rough ones stand for several.
constexpr double kBeyond = 3.0, kRoughBeyond = 8.0;

double stiffestOf(const SpringNetwork& network) {
  const SparseMatrix stiffness = stiffnessMatrix(rigidityMatrix(network));
  return largestEigenvalue([&](const Eigen::VectorXd& x) -> Eigen::VectorXd { return stiffness * x; },
                           stiffness.rows());
}

/// By how much a unit of each mode stretches each pair, squared.
BraceChoice stretches(const BracedPiece& piece, const Modes& modes, std::uint64_t seed) {
  const std::vector<Eigen::Vector3d>& points = piece.network.restPoints;
  BraceChoice choice(static_cast<std::size_t>(modes.shapes.cols()),
                     candidatePairs(piece, kMostSoftCandidates, seed));
  for (std::size_t p = 0; p < choice.pairs.size(); ++p) {
    const auto [a, b] = choice.pairs[p];
    const Eigen::RowVector3d n = (points[b] - points[a]).normalized().transpose();
    const Eigen::RowVectorXd stretch = n * (modes.shapes.middleRows<3>(3 * Eigen::Index(b)) -
                                            modes.shapes.middleRows<3>(3 * Eigen::Index(a)));
    choice.benefit.col(static_cast<Eigen::Index>(p)) = stretch.cwiseAbs2().transpose().cast<float>();
  }
  return choice;
}

/// Adds braces until the eigenvalue of each mode that is softer than `least` has, to first order, reached the
/// goal: a brace of stiffness w that a unit of the mode stretches by c adds  w c^2.  Softer modes weigh more,
/// by the square. The others are the body's own large motions, such as the opening of the arms of an L, which
/// braces are not to tie.
bool braceModes(BracedPiece& piece, const Modes& modes, double least, double goal, std::size_t cap,
                std::uint64_t seed) {
  BraceChoice choice = stretches(piece, modes, seed);
  Eigen::VectorXf eigenvalues = modes.eigenvalues.cast<float>().cwiseMax(static_cast<float>(1e-3 * goal));
  const Eigen::VectorXf tooSoft = (modes.eigenvalues.array() < least).cast<float>();
  bool added = false;
  while (piece.braces.size() < cap) {
    const Eigen::VectorXf weights =
        (eigenvalues.array() < static_cast<float>(goal))
            .select(tooSoft.array() * eigenvalues.array().square().inverse(), 0.0f)
            .matrix();
    if (weights.maxCoeff() <= 0.0f) break;
    const Eigen::VectorXf gains = addBest(piece, choice, weights);
    if (gains.size() == 0) break;
    eigenvalues += static_cast<float>(piece.weight) * gains;
    added = true;
  }
  return added;
}

}  // namespace

double leastModeRatio(std::size_t points) {
  return std::min(kLeastRatio, kLeastRatioTimesPoints / static_cast<double>(points));
}

namespace {

bool isLarge(const SpringNetwork& network) { return network.restPoints.size() > kMany; }

Modes modesToBrace(const SpringNetwork& network) {
  if (isLarge(network)) return roughModes(network, kRoughModes);
  return softestModes(network, std::clamp(network.restPoints.size() / 8, kLeastModes, kMostModes));
}

}  // namespace

void addSoftModeBraces(BracedPiece& piece, std::size_t most, std::uint64_t seed, const GoOn& goOn) {
  const std::size_t cap = std::min(most, piece.mostBraces);
  for (int round = 0; round < kMostBraceRounds && piece.braces.size() < cap; ++round) {
    if (!goOn(static_cast<double>(round) / kMostBraceRounds)) return;
    const Modes modes = modesToBrace(piece.network);
    if (modes.eigenvalues.size() == 0) return;
    const double least = leastModeRatio(piece.network.restPoints.size()) * stiffestOf(piece.network);
    if (modes.eigenvalues[0] >= least) return;
    const double goal = (isLarge(piece.network) ? kRoughBeyond : kBeyond) * least;
    if (!braceModes(piece, modes, least, goal, cap, seed + static_cast<std::uint64_t>(round))) return;
  }
}

}  // namespace limber
