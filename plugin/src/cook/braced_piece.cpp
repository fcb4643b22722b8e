// SPDX-License-Identifier: Zlib
#include "cook/braced_piece.h"

#include "core/random.h"

#include <algorithm>

namespace limber {
namespace {

/// Springs between the ends of a near pair.
constexpr std::uint32_t kShortestWalk = 2, kLongestWalk = 16;

Edge ordered(std::uint32_t a, std::uint32_t b) { return {std::min(a, b), std::max(a, b)}; }

std::vector<Edge> allPairs(std::uint32_t points) {
  std::vector<Edge> pairs;
  for (std::uint32_t a = 0; a < points; ++a)
    for (std::uint32_t b = a + 1; b < points; ++b) pairs.push_back({a, b});
  return pairs;
}

std::uint32_t walk(const InsideChords& chords, std::uint32_t from, Random& random) {
  for (std::uint32_t steps = kShortestWalk + random.below(kLongestWalk - kShortestWalk + 1); steps > 0;
       --steps)
    if (!chords.neighbours(from).empty())
      from = chords.neighbours(from)[random.below(chords.neighbours(from).size())];
  return from;
}

void boundAll(BraceChoice& choice, const Eigen::VectorXf& weights) {
  const Eigen::VectorXf sums = choice.benefit.transpose() * weights;
  for (Eigen::Index pair = 0; pair < sums.size(); ++pair)
    if (sums[pair] > 0.0f) choice.bounds.push_back({sums[pair], pair});
  std::make_heap(choice.bounds.begin(), choice.bounds.end());
  choice.bounded = true;
}

}  // namespace

void addBrace(BracedPiece& piece, const Edge& pair) {
  const NetworkSpring brace{pair[0], pair[1], SpringKind::Brace, piece.weight};
  std::vector<NetworkSpring>& springs = piece.network.springs;
  const auto place = std::upper_bound(
      springs.begin(), springs.end(), brace,
      [](const NetworkSpring& s, const NetworkSpring& t) { return s.a != t.a ? s.a < t.a : s.b < t.b; });
  springs.insert(place, brace);
  piece.chords.join(pair[0], pair[1]);
  piece.braces.push_back(pair);
}

Eigen::VectorXf addBest(BracedPiece& piece, BraceChoice& choice, const Eigen::VectorXf& weights) {
  if (!choice.bounded) boundAll(choice, weights);
  while (!choice.bounds.empty()) {
    std::pop_heap(choice.bounds.begin(), choice.bounds.end());
    BraceChoice::Bound best = choice.bounds.back();
    choice.bounds.pop_back();
    const Edge& pair = choice.pairs[static_cast<std::size_t>(best.pair)];
    best.sum = choice.benefit.col(best.pair).dot(weights);
    if (!(best.sum > 0.0f) || !piece.chords.allowed(pair[0], pair[1])) continue;
    if (!choice.bounds.empty() && best < choice.bounds.front()) {
      choice.bounds.push_back(best);
      std::push_heap(choice.bounds.begin(), choice.bounds.end());
      continue;
    }
    addBrace(piece, pair);
    return choice.benefit.col(best.pair);
  }
  return {};
}

std::vector<Edge> candidatePairs(const BracedPiece& piece, std::size_t most, std::uint64_t seed) {
  const std::size_t n = piece.network.restPoints.size();
  if (n * (n - 1) / 2 <= most) return allPairs(static_cast<std::uint32_t>(n));
  Random random(seed);
  std::vector<Edge> pairs;
  for (std::size_t i = 0; i < most; ++i) {
    const std::uint32_t a = random.below(n);
    const std::uint32_t b = i % 2 == 0 ? random.below(n) : walk(piece.chords, a, random);
    if (a != b) pairs.push_back(ordered(a, b));
  }
  std::sort(pairs.begin(), pairs.end());
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  return pairs;
}

}  // namespace limber
