// SPDX-License-Identifier: Zlib
#include "cook/counterexample_braces.h"

#include "cook/deformations.h"
#include "cook/random.h"
#include "cook/relaxation.h"

#include <algorithm>
#include <cmath>

namespace limber {
namespace {

constexpr int kCleanRounds = 5;
constexpr std::size_t kRuns = 20;  // of a round

/// Candidate pairs that are looked at in a round at most.
constexpr std::size_t kMostCandidates = 200000;

/// How fast an example's say fades with what braces do for it already.
constexpr double kCovered = 0.5;

/// Wrong shapes, points as columns.
using Examples = std::vector<Points>;

std::vector<Edge> allPairs(std::uint32_t n) {
  std::vector<Edge> pairs;
  for (std::uint32_t a = 0; a < n; ++a)
    for (std::uint32_t b = a + 1; b < n; ++b) pairs.push_back({a, b});
  return pairs;
}

std::vector<Edge> somePairs(std::uint32_t n, Random& random) {
  std::vector<Edge> pairs;
  for (std::size_t i = 0; i < kMostCandidates; ++i) {
    const std::uint32_t a = random.below(n), b = random.below(n);
    if (a != b) pairs.push_back({std::min(a, b), std::max(a, b)});
  }
  return pairs;
}

struct Scores {
  std::vector<Edge> pairs;
  Eigen::MatrixXf wrong;  ///< #examples x #pairs, squared errors of length over the example's largest
};

Scores scoresOf(const RelaxedBody& body, const Examples& examples, std::vector<Edge> pairs) {
  Scores s;
  static const double pw = getenv("SCORE") ? atof(getenv("SCORE")) : 0.0;
  s.wrong.resize(static_cast<Eigen::Index>(examples.size()), static_cast<Eigen::Index>(pairs.size()));
  for (std::size_t p = 0; p < pairs.size(); ++p) {
    const auto [a, b] = pairs[p];
    const double rest = (body.rest.col(a) - body.rest.col(b)).norm();
    for (std::size_t f = 0; f < examples.size(); ++f) {
      const double error = (examples[f].col(a) - examples[f].col(b)).norm() - rest;
      s.wrong(Eigen::Index(f), Eigen::Index(p)) = float(error * error / std::pow(rest, pw));
    }
  }
  s.pairs = std::move(pairs);
  return s;
}

/// Braces `count` pairs, each time the one with the most error over all examples.
std::size_t braceWorst(SpringNetwork& network, InsideChords& chords, Scores& s, std::size_t count,
                       double weight) {
  Eigen::VectorXf say = Eigen::VectorXf::Ones(s.wrong.rows());
  std::vector<std::size_t> order(s.pairs.size());
  std::size_t added = 0;
  // errors count against the largest allowed one
  Eigen::VectorXf largest = Eigen::VectorXf::Zero(s.wrong.rows());
  for (Eigen::Index f = 0; f < s.wrong.rows(); ++f) {
    for (std::size_t p = 0; p < s.pairs.size(); ++p)
      if (s.wrong(f, Eigen::Index(p)) > largest[f] && chords.allowed(s.pairs[p][0], s.pairs[p][1]))
        largest[f] = s.wrong(f, Eigen::Index(p));
    if (largest[f] > 0) s.wrong.row(f) /= largest[f];
  }
  std::vector<bool> gone(s.pairs.size(), false);
  while (added < count) {
    Eigen::VectorXf score = s.wrong.transpose() * say;
    for (std::size_t p = 0; p < s.pairs.size(); ++p) if (gone[p]) score[Eigen::Index(p)] = -1;
    Eigen::Index best = 0;
    bool ok = false;
    for (;;) {
      const float value = score.maxCoeff(&best);
      if (value <= 0) break;
      const Edge& e = s.pairs[std::size_t(best)];
      if (chords.allowed(e[0], e[1])) { ok = true; break; }
      score[best] = -1; gone[std::size_t(best)] = true;
    }
    if (!ok) break;
    const Edge e = s.pairs[std::size_t(best)];
    chords.join(e[0], e[1]);
    addBrace(network, e, weight);
    ++added;
    gone[std::size_t(best)] = true;
    for (Eigen::Index f = 0; f < say.size(); ++f) say[f] /= 1.0f + s.wrong(f, best) / float(kCovered);
  }
  return added;
}

Examples wrongOnes(RelaxedBody& body, std::size_t count, const std::function<Points(std::size_t)>& start) {
  std::vector<Points> ends(count);
  relax(body, count, start, [&](std::size_t i, const Points& x) {
    if (distanceToRest(body, x) >= kReturned) ends[i] = x;
    return true;
  });
  Examples wrong;
  for (Points& x : ends)
    if (x.cols() > 0) wrong.push_back(std::move(x));
  return wrong;
}

std::size_t bracesOf(const SpringNetwork& network) {
  return std::size_t(std::count_if(network.springs.begin(), network.springs.end(),
                       [](const NetworkSpring& s) { return s.kind == SpringKind::Brace; }));
}

}  // namespace

void addBrace(SpringNetwork& network, const Edge& pair, double weight) {
  const NetworkSpring brace{pair[0], pair[1], SpringKind::Brace, weight};
  const auto place = std::upper_bound(
      network.springs.begin(), network.springs.end(), brace,
      [](const NetworkSpring& s, const NetworkSpring& t) { return s.a != t.a ? s.a < t.a : s.b < t.b; });
  network.springs.insert(place, brace);
}

void braceCounterexamples(SpringNetwork& network, InsideChords& chords,
                          const CounterexampleSettings& settings) {
  const auto n = static_cast<std::uint32_t>(network.restPoints.size());
  Random random(settings.seed);
  int clean = 0;
  const double share = getenv("SHARE") ? atof(getenv("SHARE")) : 0.5;
  const int inner = getenv("INNER") ? atoi(getenv("INNER")) : 6;
  for (std::size_t round = 0; clean < kCleanRounds; ++round) {
    if (settings.goOn && !settings.goOn(double(clean) / kCleanRounds)) return;
    RelaxedBody body(network);
    Examples wrong = wrongOnes(body, kRuns, [&](std::size_t i) {
      return deform(body.rest, Deformation(i % 5), settings.seed, round * kRuns + i);
    });
    clean = wrong.empty() ? clean + 1 : 0;
    if (getenv("LOG")) printf("[round %zu wrong %zu braces %zu]\n", round, wrong.size(), bracesOf(network));
    for (int k = 0; k < inner && !wrong.empty(); ++k) {
      const std::size_t have = bracesOf(network);
      if (have >= settings.mostBraces) return;
      std::vector<Edge> pairs = std::size_t(n) * (n - 1) / 2 <= kMostCandidates ? allPairs(n) : somePairs(n, random);
      Scores s = scoresOf(body, wrong, std::move(pairs));
      const std::size_t want = std::min(settings.mostBraces - have, std::max<std::size_t>(1, std::size_t(std::ceil(share * double(wrong.size())))));
      if (braceWorst(network, chords, s, want, settings.weight) == 0) break;
      body = RelaxedBody(network);
      wrong = wrongOnes(body, wrong.size(), [&](std::size_t i) { return wrong[i]; });
      if (getenv("LOG")) printf("   inner %d: +%zu wrong %zu\n", k, want, wrong.size());
    }
  }
}

}  // namespace limber
