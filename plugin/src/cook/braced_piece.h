// SPDX-License-Identifier: Zlib
#pragma once

#include "cook/inside_chords.h"

#include <limber/spring_network.h>

#include <Eigen/Core>

#include <functional>
#include <vector>

namespace limber {

/// A piece of a body that is being braced.
struct BracedPiece {
  SpringNetwork network;  ///< points, springs and, turned outwards, the surface; no masses, no render surface
  InsideChords chords;
  double weight = 1.0;         ///< stiffnessScale of a brace
  std::size_t mostBraces = 0;  ///< in all that it may get
  std::vector<Edge> braces;    ///< in the order they were added

  bool full() const { return braces.size() >= mostBraces; }
};

/// Whether to go on, told how far the present work is, 0 to 1.
using GoOn = std::function<bool(double)>;

/// The pair must be allowed and the piece not full.
void addBrace(BracedPiece& piece, const Edge& pair);

/// Pairs to choose braces from, and what each is good for.
struct BraceChoice {
  std::vector<Edge> pairs;
  Eigen::MatrixXf benefit;  ///< #purposes x #pairs, 0 or more

  BraceChoice(std::size_t purposes, std::vector<Edge> candidates)
      : pairs(std::move(candidates)),
        benefit(static_cast<Eigen::Index>(purposes), static_cast<Eigen::Index>(pairs.size())) {}

  /// A pair and what its sum of benefits times weights is at most. Of equals the first pair is the larger.
  struct Bound {
    float sum;
    Eigen::Index pair;
    bool operator<(const Bound& other) const {
      return sum != other.sum ? sum < other.sum : pair > other.pair;
    }
  };
  std::vector<Bound> bounds;  ///< heap of the pairs that may still be of use; made by addBest()
  bool bounded = false;
};

/// Adds the allowed pair with the largest sum of benefits times weights (#purposes) and strikes it off the
/// choice. Returns its benefits, or nothing when no pair is of use. The benefits must not change between
/// calls and no weight may grow: then what a pair was worth before bounds what it is worth now, and few are
/// looked at again (M. Minoux, "Accelerated greedy algorithms", 1978).
Eigen::VectorXf addBest(BracedPiece& piece, BraceChoice& choice, const Eigen::VectorXf& weights);

/// All pairs of the piece's points or, where they are more than `most`, that many seeded ones: half of them
/// anywhere, half of them some springs apart, so that thin parts of a large body have theirs.
std::vector<Edge> candidatePairs(const BracedPiece& piece, std::size_t most, std::uint64_t seed);

}  // namespace limber
