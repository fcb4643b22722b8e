// SPDX-License-Identifier: Zlib
// Braces are springs that keep the shape of a body. This header declares the rules that find them, and the
// piece of a body that is being braced.
#pragma once

#include "mesh/edges.h"
#include "mesh/triangle_bvh.h"

#include <limber/network_builder.h>
#include <limber/spring_network.h>

#include <Eigen/Core>

#include <cstdint>
#include <functional>
#include <unordered_map>
#include <vector>

namespace limber {

/// All pairs of the `points` points that share a neighbour and are no edge themselves, sorted. `edges` must
/// be sorted and unique.
std::vector<Edge> findTwoRingPairs(std::size_t points, const std::vector<Edge>& edges);

/// Which pairs of points of a surface may still be joined by a brace: those without a spring whose chord
/// stays inside. Asks the surface about a pair once at most.
class InsideChords {
 public:
  /// Triangles outwards; `edges` are the springs there are.
  InsideChords(const std::vector<Eigen::Vector3d>& points, const std::vector<Triangle>& triangles,
               const std::vector<Edge>& edges);

  const TriangleBvh& surface() const { return surface_; }
  double size() const { return size_; }  ///< m, the largest extent
  const std::vector<std::uint32_t>& neighbours(std::uint32_t point) const { return neighbours_[point]; }

  bool joined(std::uint32_t a, std::uint32_t b) const;
  bool allowed(std::uint32_t a, std::uint32_t b);
  void join(std::uint32_t a, std::uint32_t b);

 private:
  std::vector<Eigen::Vector3d> points_;
  double size_;
  TriangleBvh surface_;
  std::vector<std::vector<std::uint32_t>> neighbours_;  ///< #points, along springs
  std::unordered_map<std::uint64_t, bool> inside_;      ///< of pairs asked for so far
};

/// A piece of a body that is being braced.
struct BracedPiece {
  SpringNetwork network;  ///< points, springs and, turned outwards, the surface; no masses, no render surface
  InsideChords chords;
  double weight = 1.0;                ///< stiffnessScale of a brace
  std::size_t maxBracesPerPoint = 0;  ///< in all that it may get
  std::vector<Edge> braces;           ///< in the order they were added

  bool full() const { return braces.size() >= maxBracesPerPoint; }
};

/// Whether to go on, told how far the present work is, 0 to 1.
using GoOn = std::function<bool(double)>;

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

/// The ratio of the eigenvalues of the softest and the stiffest oscillation that braces aim at: 1e-3, and
/// less for many points, by as much as that of a solid ball falls.
double leastModeRatio(std::size_t points);

/// Counterexample-guided insertion: lets the piece go from large random deformations and braces the wrong
/// shapes it comes to rest in, until it has come back from all of them in several rounds in a row, or is
/// full. A spring that has its rest length in a wrong shape does nothing against it; the pair whose distance
/// is most wrong there does most.
void addCounterexampleBraces(BracedPiece& piece, std::uint64_t seed, const GoOn& goOn);

/// One connected piece of a surface, and what bracing it takes.
struct PieceToBrace {
  std::vector<Eigen::Vector3d> points;
  std::vector<Triangle> triangles;
  std::vector<Edge> edges;  ///< of the triangles, sorted, unique
  bool closed = false;      ///< every edge has two triangles that run through it in opposite directions
};

/// With less, a body is a skin that is stiff against bending around an inside that is soft: at 0.3 the arms
/// of an L resist opening 1.6 times as much as a solid's with the same bulk modulus, at 0.5 1.4 times.
constexpr double kPipelineWeight = 0.5;

struct BracingSettings {
  double weight = kPipelineWeight;  ///< stiffnessScale of a brace
  double maxBracesPerPoint = 1.5;   ///< per point
  std::uint64_t seed = 1;
};

/// The braces of BraceRule::Pipeline, sorted:
///
///   1. chords through the body, from each point to the opposite side,
///   2. braces for mechanisms and what is nearly one,
///   3. braces for the wrong shapes that large deformations leave it in (addCounterexampleBraces()),
///
/// all inside the body. A piece without an inside (flat, or so open that few chords are inside) gets the
/// two-ring instead, however many braces that is. Once `goOn` returns false it must do so ever after; then
/// the braces found so far are returned.
std::vector<Edge> bracePiece(const PieceToBrace& piece, const BracingSettings& settings,
                             const Progress& goOn);

}  // namespace limber
