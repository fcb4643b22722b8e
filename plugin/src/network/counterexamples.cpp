// SPDX-License-Identifier: Zlib
// Releases a piece of a body from large random deformations and braces the wrong shapes in which it comes to
// rest.

#include "network/bracing.h"

#include "mesh/random.h"
#include "network/relaxation.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace limber {
namespace {

constexpr int kCleanRounds = 12, kMaxRounds = 60;

/// Limit for all runs together, in runs of a body of one point. A run takes about points^1.5, because the
/// number of steps grows with the distance across the body. 5 000 points get 56 runs, 1 000 get 630.
constexpr double kMaxWork = 2.0e7;

/// Runs per round: kRunsOfEach of each kind of deformation, and further ones, preferably of kinds that failed
/// before.
constexpr std::size_t kRunsOfEach = 2, kFurtherRuns = 10;
constexpr std::size_t kRuns = kRunsOfEach * kDeformations + kFurtherRuns;

/// Rounds of further braces for a wrong shape before it is dropped for new ones.
constexpr int kMaxTries = 6;
constexpr double kBracesPerExample = 0.5;  // per round
constexpr std::size_t kMaxCandidates = 100000;

/// A brace of this relative benefit for a wrong shape halves the weight of that shape.
constexpr float kHalvingBenefit = 0.5f;

/// A shape in which a run ended.
struct Example {
  Deformation kind;
  Points x;
};
using Examples = std::vector<Example>;

struct Trials {
  std::uint64_t seed;
  std::size_t runsLeft;
  std::array<std::uint32_t, kDeformations> failures{};
};

std::size_t maxRuns(std::size_t points) {
  return static_cast<std::size_t>(kMaxWork / std::pow(static_cast<double>(points), 1.5));
}

std::vector<Deformation> kindsOfRound(const Trials& trials, Random& random) {
  std::vector<Deformation> kinds;
  for (std::size_t i = 0; i < kRunsOfEach * kDeformations; ++i)
    kinds.push_back(static_cast<Deformation>(i % kDeformations));
  std::vector<Deformation> weighted(kinds.begin(), kinds.begin() + kDeformations);
  for (std::size_t k = 0; k < kDeformations; ++k)
    weighted.insert(weighted.end(), trials.failures[k], static_cast<Deformation>(k));
  while (kinds.size() < kRuns) kinds.push_back(weighted[random.below(weighted.size())]);
  return kinds;
}

/// The mirror image does not count as wrong: all its distances are correct, so no brace can resist it.
bool isWrong(const RelaxedBody& body, const Points& x) {
  return x.allFinite() && distanceToRest(body, x) >= kReturned && distanceToRest(body, -x) >= kReturned;
}

/// Relaxes the starts and returns the wrong shapes among the results.
Examples findWrongShapes(RelaxedBody& body, const Examples& starts, Trials& trials,
                         const std::function<bool()>& goOn) {
  trials.runsLeft -= std::min(trials.runsLeft, starts.size());
  Examples ends(starts.size());
  relax(
      body, starts.size(), [&](std::size_t i) { return starts[i].x; },
      [&](std::size_t i, const Points& x) {
        if (isWrong(body, x)) ends[i] = {starts[i].kind, x};
        return goOn();
      });
  ends.erase(std::remove_if(ends.begin(), ends.end(), [](const Example& e) { return e.x.cols() == 0; }),
             ends.end());
  return ends;
}

Examples startsOfRound(const RelaxedBody& body, const Trials& trials, std::uint64_t round) {
  Random random(trials.seed ^ (round << 32));
  Examples starts;
  for (const Deformation kind : kindsOfRound(trials, random))
    starts.push_back({kind, deform(body.rest, kind, trials.seed, kRuns * round + starts.size())});
  return starts;
}

/// Computes the squared errors of length, divided by the largest one of an allowed pair in each example.
BraceChoice errorsOf(BracedPiece& piece, const RelaxedBody& body, const Examples& examples,
                     std::uint64_t seed) {
  BraceChoice choice(examples.size(), candidatePairs(piece, kMaxCandidates, seed));
  Eigen::VectorXf largest = Eigen::VectorXf::Constant(choice.benefit.rows(), 1e-30f);
  for (std::size_t p = 0; p < choice.pairs.size(); ++p) {
    const auto [a, b] = choice.pairs[p];
    const double rest = (body.rest.col(a) - body.rest.col(b)).norm();
    auto errors = choice.benefit.col(static_cast<Eigen::Index>(p));
    for (std::size_t f = 0; f < examples.size(); ++f) {
      const double error = (examples[f].x.col(a) - examples[f].x.col(b)).norm() - rest;
      errors[static_cast<Eigen::Index>(f)] = static_cast<float>(error * error);
    }
    if ((errors.array() > largest.array()).any() && piece.chords.allowed(a, b))
      largest = largest.cwiseMax(errors);
  }
  choice.benefit = largest.cwiseInverse().asDiagonal() * choice.benefit;
  return choice;
}

bool braceWorst(BracedPiece& piece, const RelaxedBody& body, const Examples& examples, std::uint64_t seed) {
  BraceChoice choice = errorsOf(piece, body, examples, seed);
  Eigen::VectorXf weights = Eigen::VectorXf::Ones(choice.benefit.rows());
  const double maxAdded = std::ceil(kBracesPerExample * static_cast<double>(examples.size()));
  for (int added = 0; added < static_cast<int>(maxAdded) && !piece.full(); ++added) {
    const Eigen::VectorXf benefits = addBest(piece, choice, weights);
    if (benefits.size() == 0) return added > 0;
    weights.array() /= 1.0f + benefits.array() / kHalvingBenefit;
  }
  return true;
}

/// Braces the wrong shapes and relaxes the piece from them, until it leaves all of them.
void braceExamples(BracedPiece& piece, Examples wrong, std::uint64_t seed, Trials& trials,
                   const std::function<bool()>& goOn) {
  for (int tries = 0; tries < kMaxTries && !wrong.empty() && !piece.full() && goOn(); ++tries) {
    if (!braceWorst(piece, RelaxedBody(piece.network), wrong, seed + static_cast<std::uint64_t>(tries)))
      return;
    RelaxedBody braced(piece.network);
    if (trials.runsLeft == 0) return;
    wrong = findWrongShapes(braced, wrong, trials, goOn);
  }
}

}  // namespace

void addCounterexampleBraces(BracedPiece& piece, std::uint64_t seed, const GoOn& goOn) {
  Trials trials{seed, maxRuns(piece.network.restPoints.size())};
  int clean = 0;
  double done = 0.0;  // never decreases, even after a round that is not clean
  for (int round = 0; round < kMaxRounds && clean < kCleanRounds && !piece.full() && trials.runsLeft > 0;
       ++round) {
    done =
        std::max({done, static_cast<double>(clean) / kCleanRounds, static_cast<double>(round) / kMaxRounds});
    bool going = true;
    const std::function<bool()> keepGoing = [&] { return going = going && goOn(done); };
    RelaxedBody body(piece.network);
    Examples wrong = findWrongShapes(body, startsOfRound(body, trials, static_cast<std::uint64_t>(round)),
                                     trials, keepGoing);
    if (!going) return;
    clean = wrong.empty() ? clean + 1 : 0;
    for (const Example& e : wrong) ++trials.failures[static_cast<std::size_t>(e.kind)];
    braceExamples(piece, std::move(wrong), seed + (static_cast<std::uint64_t>(round) << 16), trials,
                  keepGoing);
  }
}

}  // namespace limber
