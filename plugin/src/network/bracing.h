// SPDX-License-Identifier: Zlib
// Braces are springs that keep the shape of a body. This header declares the rules that find them and the
// piece of a body that is being braced.
#pragma once

#include "mesh/triangle_bvh.h"

#include <limber/network_builder.h>

#include <Eigen/Core>

#include <cstdint>
#include <unordered_map>
#include <vector>

namespace limber {

/// The order of a network's springs.
inline bool isBefore(const NetworkSpring& s, const NetworkSpring& t) {
  return s.a != t.a ? s.a < t.a : s.b < t.b;
}

inline bool hasSpring(const SpringNetwork& network, const Edge& pair) {
  return std::binary_search(network.springs.begin(), network.springs.end(), NetworkSpring{pair[0], pair[1]},
                            isBefore);
}

/// Returns for each point those to which springs join it.
std::vector<std::vector<std::uint32_t>> neighboursOf(const SpringNetwork& network);

/// Returns all pairs of points that share a neighbour but no spring, sorted. Around points with more than
/// `maxNeighbours`, whose pairs would be too many, each neighbour is only paired with the one opposite.
std::vector<Edge> findTwoRingPairs(const SpringNetwork& network, std::size_t maxNeighbours = kNoPoint);

/// A piece of a body that is being braced.
struct BracedPiece {
  SpringNetwork network;  ///< points, springs and a surface that faces outwards; no masses, no render surface
  double weight = 1.0;    ///< stiffnessScale of a brace
  std::size_t maxBraces = 0;   ///< limit for the whole piece
  std::vector<Edge> braces{};  ///< in the order they were added
  TriangleBvh surface{network.restPoints, network.surface};
  double size = extent(network.restPoints);                                    ///< m
  std::vector<std::vector<std::uint32_t>> neighbours = neighboursOf(network);  ///< #points
  std::unordered_map<std::uint64_t, bool> isInside{};  ///< whether the chords tested so far stay inside

  bool full() const { return braces.size() >= maxBraces; }

  /// Returns whether a brace may join the points: they have no spring, and their chord stays inside. Tests
  /// the chord of each pair at most once.
  bool allows(std::uint32_t a, std::uint32_t b);

  /// Adds a brace. The pair must be allowed and the piece not full.
  void add(const Edge& pair);
};

/// Candidate pairs for braces and their benefits.
struct BraceChoice {
  std::vector<Edge> pairs;
  Eigen::MatrixXf benefit;  ///< #purposes x #pairs, 0 or more

  BraceChoice(std::size_t purposes, std::vector<Edge> candidates)
      : pairs(std::move(candidates)),
        benefit(static_cast<Eigen::Index>(purposes), static_cast<Eigen::Index>(pairs.size())) {}

  /// A pair and an upper bound of its sum of benefits times weights. Of equal bounds, that of the first pair
  /// counts as larger.
  struct Bound {
    float sum;
    Eigen::Index pair;
    bool operator<(const Bound& other) const {
      return sum != other.sum ? sum < other.sum : pair > other.pair;
    }
  };
  std::vector<Bound> bounds;  ///< heap of the pairs that may still have a benefit; filled by addBest()
  bool bounded = false;
};

/// Adds the allowed pair with the largest sum of benefits times weights (#purposes) as a brace and removes it
/// from the choice. Returns its benefits, or an empty vector if no pair has a benefit. The benefits must not
/// change between calls, and no weight may grow. Then an earlier sum of a pair is an upper bound of its
/// present sum, and few sums are computed again (M. Minoux, "Accelerated greedy algorithms", 1978).
Eigen::VectorXf addBest(BracedPiece& piece, BraceChoice& choice, const Eigen::VectorXf& weights);

/// Returns all pairs of the piece's points if they are at most `maxPairs`, else about that many random pairs:
/// half of them anywhere, half of them some springs apart, so that thin parts of a large body have candidates
/// too.
std::vector<Edge> candidatePairs(const BracedPiece& piece, std::size_t maxPairs, std::uint64_t seed);

/// Returns the smallest allowed ratio of the eigenvalues of the softest and the stiffest oscillation after
/// bracing: 1e-3. For many points it is lower, as is the ratio of a solid ball.
double minModeRatio(std::size_t points);

/// Returns the stiffnessScale of a brace.
double braceWeight(const NetworkSettings& settings);

/// Returns the braces of BraceRule::Pipeline for a connected piece, a network of the edges of its surface,
/// sorted:
///
///   1. chords through the body, from each point to the opposite side,
///   2. braces for mechanisms and near mechanisms,
///   3. braces for the wrong shapes that remain after large deformations.
///
/// All braces are inside the body. A piece without an inside (flat, or so open that few chords are inside)
/// gets the braces of BraceRule::TwoRing instead, without the limit. Once `goOn` has returned false, it must
/// return false in all later calls; the braces found so far are returned.
std::vector<Edge> bracePiece(const SpringNetwork& piece, const NetworkSettings& settings,
                             const Progress& goOn);

}  // namespace limber
