// SPDX-License-Identifier: Zlib
// Braces a piece of a body: first with chords through its inside, then with braces for its soft modes, then
// with braces for the wrong shapes in which it comes to rest after large random deformations.

#include "network/bracing.h"

#include "mesh/random.h"
#include "network/stability.h"

#include <atomic>
#include <thread>

namespace limber {

std::vector<std::vector<std::uint32_t>> neighboursOf(const SpringNetwork& network) {
  std::vector<std::vector<std::uint32_t>> neighbours(network.restPoints.size());
  for (const NetworkSpring& s : network.springs) {
    neighbours[s.a].push_back(s.b);
    neighbours[s.b].push_back(s.a);
  }
  return neighbours;
}

/// Returns the one of the neighbours of a point that is most nearly on its other side as seen from `a`.
static std::uint32_t oppositeOf(std::uint32_t a, const std::vector<Eigen::Vector3d>& points,
                                std::uint32_t point, const std::vector<std::uint32_t>& neighbours) {
  const Eigen::Vector3d there = points[a] - points[point];
  const auto cosine = [&](std::uint32_t b) {
    return there.dot((points[b] - points[point]).normalized());  // times a constant
  };
  return *std::min_element(neighbours.begin(), neighbours.end(),
                           [&](std::uint32_t b, std::uint32_t c) { return cosine(b) < cosine(c); });
}

std::vector<Edge> findTwoRingPairs(const SpringNetwork& network, std::size_t maxNeighbours) {
  const std::vector<std::vector<std::uint32_t>> neighbours = neighboursOf(network);
  std::vector<Edge> pairs;
  const auto add = [&](std::uint32_t a, std::uint32_t b) {
    if (a < b && !hasSpring(network, {a, b})) pairs.push_back({a, b});
  };
  for (std::uint32_t point = 0; point < neighbours.size(); ++point) {
    const std::vector<std::uint32_t>& around = neighbours[point];
    for (const std::uint32_t a : around) {
      if (around.size() <= maxNeighbours) {
        for (const std::uint32_t b : around) add(a, b);
      } else {
        const std::uint32_t b = oppositeOf(a, network.restPoints, point, around);
        add(std::min(a, b), std::max(a, b));
      }
    }
  }
  sortUnique(pairs);
  return pairs;
}

bool BracedPiece::allows(std::uint32_t a, std::uint32_t b) {
  // fraction of the size by which a chord may leave the surface: the rounding of single precision
  constexpr double kTolerance = 1e-6;
  const std::vector<std::uint32_t>& ofA = neighbours[a];
  if (a == b || std::find(ofA.begin(), ofA.end(), b) != ofA.end()) return false;
  if (a > b) std::swap(a, b);
  const auto [entry, isNew] = isInside.try_emplace(static_cast<std::uint64_t>(a) << 32 | b, false);
  const std::vector<Eigen::Vector3d>& points = network.restPoints;
  if (isNew) entry->second = surface.staysInside(points[a], points[b], kTolerance * size);
  return entry->second;
}

void BracedPiece::add(const Edge& pair) {
  const NetworkSpring brace{pair[0], pair[1], SpringKind::Brace, weight};
  std::vector<NetworkSpring>& springs = network.springs;
  springs.insert(std::upper_bound(springs.begin(), springs.end(), brace, isBefore), brace);
  neighbours[pair[0]].push_back(pair[1]);
  neighbours[pair[1]].push_back(pair[0]);
  braces.push_back(pair);
}

namespace {

/// Limits for the number of springs between the ends of a near pair.
constexpr std::uint32_t kShortestWalk = 2, kLongestWalk = 16;

std::vector<Edge> allPairs(std::uint32_t points) {
  std::vector<Edge> pairs;
  for (std::uint32_t a = 0; a < points; ++a)
    for (std::uint32_t b = a + 1; b < points; ++b) pairs.push_back({a, b});
  return pairs;
}

std::uint32_t randomWalk(const BracedPiece& piece, std::uint32_t from, Random& random) {
  for (std::uint32_t steps = kShortestWalk + random.below(kLongestWalk - kShortestWalk + 1); steps > 0;
       --steps)
    if (const std::vector<std::uint32_t>& next = piece.neighbours[from]; !next.empty())
      from = next[random.below(next.size())];
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

Eigen::VectorXf addBest(BracedPiece& piece, BraceChoice& choice, const Eigen::VectorXf& weights) {
  if (!choice.bounded) boundAll(choice, weights);
  while (!choice.bounds.empty()) {
    std::pop_heap(choice.bounds.begin(), choice.bounds.end());
    BraceChoice::Bound best = choice.bounds.back();
    choice.bounds.pop_back();
    const Edge& pair = choice.pairs[static_cast<std::size_t>(best.pair)];
    best.sum = choice.benefit.col(best.pair).dot(weights);
    if (!(best.sum > 0.0f) || !piece.allows(pair[0], pair[1])) continue;
    if (!choice.bounds.empty() && best < choice.bounds.front()) {
      choice.bounds.push_back(best);
      std::push_heap(choice.bounds.begin(), choice.bounds.end());
      continue;
    }
    piece.add(pair);
    return choice.benefit.col(best.pair);
  }
  return {};
}

std::vector<Edge> candidatePairs(const BracedPiece& piece, std::size_t maxPairs, std::uint64_t seed) {
  const std::size_t n = piece.network.restPoints.size();
  if (n * (n - 1) / 2 <= maxPairs) return allPairs(static_cast<std::uint32_t>(n));
  Random random(seed);
  std::vector<Edge> pairs;
  for (std::size_t i = 0; i < maxPairs; ++i) {
    const std::uint32_t a = random.below(n);
    const std::uint32_t b = i % 2 == 0 ? random.below(n) : randomWalk(piece, a, random);
    if (a != b) pairs.push_back(edgeBetween(a, b));
  }
  sortUnique(pairs);
  return pairs;
}

double minModeRatio(std::size_t points) {
  // the ratio of icospheres of n points without braces is 1.2/n: their edges alone make them rigid
  constexpr double kMinRatio = 1e-3, kMinRatioTimesPoints = 0.6;
  return std::min(kMinRatio, kMinRatioTimesPoints / static_cast<double>(points));
}

namespace {

/// Is called with the progress of the current stage, 0 to 1. Returns false to end early.
using GoOn = std::function<bool(double)>;

/// Fraction of the size; nearer hits of a ray are at its own start.
constexpr double kMinRayDistance = 1e-4;

/// Fraction of the size; longer than any ray within the body.
constexpr double kMaxRayDistance = 2.0;

using Positions = std::vector<Eigen::Vector3d>;

/// Returns the corners of the triangle that was hit, the nearest first.
Triangle byDistance(const Positions& points, Triangle t, const Eigen::Vector3d& hit) {
  std::stable_sort(t.begin(), t.end(), [&](std::uint32_t a, std::uint32_t b) {
    return (points[a] - hit).squaredNorm() < (points[b] - hit).squaredNorm();
  });
  return t;
}

/// Adds chords through the body. Each point without such a chord casts a ray along its inward normal. Its
/// chord ends at the corner nearest to the hit whose chord stays inside. These chords keep opposite walls
/// apart; no spring within the surface does.
void addAntipodalBraces(BracedPiece& piece) {
  const Positions& points = piece.network.restPoints;
  const std::vector<Triangle>& triangles = piece.network.surface;
  const Positions normals = vertexNormals(points, triangles);
  const double size = piece.size;
  std::vector<bool> hasChord(points.size(), false);
  for (std::uint32_t i = 0; i < points.size() && !piece.full(); ++i) {
    if (hasChord[i]) continue;
    const TriangleHit hit =
        piece.surface.firstHit(points[i], -normals[i], kMinRayDistance * size, kMaxRayDistance * size);
    if (!hit) continue;
    for (const std::uint32_t j : byDistance(points, triangles[hit.triangle], hit.position)) {
      if (!piece.allows(i, j)) continue;
      piece.add(edgeBetween(i, j));
      hasChord[i] = hasChord[j] = true;
      break;
    }
  }
}

constexpr int kMaxBraceRounds = 40;
constexpr std::size_t kMinModes = 30, kMaxModes = 150;  // computed at once
/// Larger bodies use this many rough modes: fewer rounds, and each takes less time.
constexpr std::size_t kLargeBody = 1000, kRoughModes = 150;
constexpr std::size_t kMaxSoftCandidates = 100000;

/// Modes are braced beyond the goal by these factors, because the estimate of their new stiffness ignores
/// that they can move sideways. A rough mode stands for several modes.
constexpr double kGoalFactor = 3.0, kRoughGoalFactor = 8.0;

/// Computes the squared stretch of each pair per unit of each mode.
BraceChoice stretches(const BracedPiece& piece, const Modes& modes, std::uint64_t seed) {
  const std::vector<Eigen::Vector3d>& points = piece.network.restPoints;
  BraceChoice choice(static_cast<std::size_t>(modes.shapes.cols()),
                     candidatePairs(piece, kMaxSoftCandidates, seed));
  for (std::size_t p = 0; p < choice.pairs.size(); ++p) {
    const auto [a, b] = choice.pairs[p];
    const Eigen::RowVector3d n = (points[b] - points[a]).normalized().transpose();
    const Eigen::RowVectorXd stretch = n * (modes.shapes.middleRows<3>(3 * Eigen::Index(b)) -
                                            modes.shapes.middleRows<3>(3 * Eigen::Index(a)));
    choice.benefit.col(static_cast<Eigen::Index>(p)) = stretch.cwiseAbs2().transpose().cast<float>();
  }
  return choice;
}

/// Adds braces until each mode with an eigenvalue below `minEigenvalue` has reached the goal to first order.
/// A brace of stiffness w that is stretched by c per unit of the mode adds  w c^2.  Softer modes weigh more,
/// by the inverse square of the eigenvalue. The other modes are large motions of the body, such as the
/// opening of the arms of an L; braces should not restrict them.
bool braceModes(BracedPiece& piece, const Modes& modes, double minEigenvalue, double goal, std::size_t cap,
                std::uint64_t seed, const std::function<bool()>& goOn) {
  if (!goOn()) return false;
  BraceChoice choice = stretches(piece, modes, seed);
  Eigen::VectorXf eigenvalues = modes.eigenvalues.cast<float>().cwiseMax(static_cast<float>(1e-3 * goal));
  const Eigen::VectorXf tooSoft = (modes.eigenvalues.array() < minEigenvalue).cast<float>();
  bool added = false;
  while (piece.braces.size() < cap && goOn()) {
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

bool isLarge(const SpringNetwork& network) { return network.restPoints.size() > kLargeBody; }

Modes modesToBrace(const SpringNetwork& network) {
  if (isLarge(network)) return roughModes(network, kRoughModes);
  return softestModes(network, std::clamp(network.restPoints.size() / 8, kMinModes, kMaxModes));
}

/// Braces mechanisms and soft oscillations: in each round the pairs that the softest modes stretch most. Ends
/// when minModeRatio() is reached, when the piece is full, or when no brace inside the body helps.
/// `maxBraces`: limit for the number of braces of the piece, in addition to its own limit.
void addSoftModeBraces(BracedPiece& piece, std::size_t maxBraces, std::uint64_t seed, const GoOn& goOn) {
  const std::size_t cap = std::min(maxBraces, piece.maxBraces);
  for (int round = 0; round < kMaxBraceRounds && piece.braces.size() < cap; ++round) {
    const auto keepGoing = [&] { return goOn(static_cast<double>(round) / kMaxBraceRounds); };
    if (!keepGoing()) return;
    const Modes modes = modesToBrace(piece.network);
    if (modes.eigenvalues.size() == 0) return;
    const double stiffest = stiffestEigenvalue(stiffnessMatrix(rigidityMatrix(piece.network)));
    const double minEigenvalue = minModeRatio(piece.network.restPoints.size()) * stiffest;
    if (modes.eigenvalues[0] >= minEigenvalue) return;
    const double goal = (isLarge(piece.network) ? kRoughGoalFactor : kGoalFactor) * minEigenvalue;
    const std::uint64_t roundSeed = seed + static_cast<std::uint64_t>(round);
    if (!braceModes(piece, modes, minEigenvalue, goal, cap, roundSeed, keepGoing)) return;
  }
}

constexpr std::size_t kCleanRounds = 12, kMaxRounds = 60;

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
  const NetworkSettings& settings;
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

double share(std::size_t part, std::size_t whole) {
  return static_cast<double>(part) / static_cast<double>(whole);
}

/// The wrong shapes of the first round that ended in any, and the number of rounds before it.
struct WrongShapes {
  std::size_t cleanRounds = 0;
  Examples shapes;
};

WrongShapes firstOf(const Examples& ends, std::size_t roundSize) {
  WrongShapes wrong;
  for (std::size_t i = 0; i < ends.size(); ++i) {
    if (i % roundSize == 0 && i > 0 && !wrong.shapes.empty()) return wrong;
    if (ends[i].x.cols() > 0) wrong.shapes.push_back(ends[i]);
    if ((i + 1) % roundSize == 0 && wrong.shapes.empty()) ++wrong.cleanRounds;
  }
  return wrong;
}

/// Is called on the calling thread with the number of runs at rest, over the size of a round. Returns false
/// to end early.
using RoundsGoOn = std::function<bool(double)>;

/// Relaxes starts of these kinds, in rounds of `roundSize`, up to the first round with wrong shapes. Runs of
/// later rounds fill the registers while a round's last runs come to rest.
WrongShapes findWrongShapes(RelaxedBody& body, const std::vector<Deformation>& kinds, std::size_t roundSize,
                            const std::function<Points(std::size_t)>& start, Trials& trials,
                            const RoundsGoOn& goOn) {
  Examples ends(kinds.size());
  std::atomic<std::size_t> finished{0};
  const std::thread::id caller = std::this_thread::get_id();
  relax(
      body, kinds.size(), start,
      [&](std::size_t i, const Points& x) -> std::size_t {
        const double rounds = share(++finished, roundSize);
        if (std::this_thread::get_id() == caller && !goOn(rounds)) return 0;
        if (!isWrong(body, x)) return kAllStarts;
        ends[i] = {kinds[i], x};
        return (i / roundSize + 1) * roundSize;
      },
      trials.settings.parallel);
  WrongShapes wrong = firstOf(ends, roundSize);
  const std::size_t rounds = wrong.cleanRounds + (wrong.shapes.empty() ? 0 : 1);
  trials.runsLeft -= std::min(trials.runsLeft, rounds * roundSize);
  return wrong;
}

/// Releases the body in up to `rounds` rounds, which are numbered from `first`.
WrongShapes releaseInRounds(RelaxedBody& body, std::size_t first, std::size_t rounds, Trials& trials,
                            const RoundsGoOn& goOn) {
  rounds = std::min(rounds, (trials.runsLeft + kRuns - 1) / kRuns);
  std::vector<Deformation> kinds;
  for (std::size_t round = first; round < first + rounds; ++round) {
    Random random(trials.settings.seed ^ (static_cast<std::uint64_t>(round) << 32));
    const std::vector<Deformation> more = kindsOfRound(trials, random);
    kinds.insert(kinds.end(), more.begin(), more.end());
  }
  const auto start = [&](std::size_t i) {
    return deform(body.rest, kinds[i], trials.settings.seed, kRuns * first + i);
  };
  return findWrongShapes(body, kinds, kRuns, start, trials, goOn);
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
    if ((errors.array() > largest.array()).any() && piece.allows(a, b)) largest = largest.cwiseMax(errors);
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
    std::vector<Deformation> kinds;
    for (const Example& e : wrong) kinds.push_back(e.kind);
    wrong = findWrongShapes(
                braced, kinds, kinds.size(), [&](std::size_t i) { return wrong[i].x; }, trials,
                [&](double) { return goOn(); })
                .shapes;
  }
}

/// Counterexample-guided insertion: releases the piece from large random deformations and braces the wrong
/// shapes in which it comes to rest. Ends when it has returned from all deformations in several rounds in a
/// row, or when the piece is full. A spring that has its rest length in a wrong shape does not resist that
/// shape. The best brace is the pair whose distance has the largest error there.
void addCounterexampleBraces(BracedPiece& piece, const NetworkSettings& settings, const GoOn& goOn) {
  Trials trials{settings, maxRuns(piece.network.restPoints.size())};
  std::size_t clean = 0;
  double done = 0.0;  // never decreases, even after a round that is not clean
  for (std::size_t round = 0;
       round < kMaxRounds && clean < kCleanRounds && !piece.full() && trials.runsLeft > 0;) {
    done = std::max({done, share(clean, kCleanRounds), share(round, kMaxRounds)});
    bool going = true;
    const auto keepGoing = [&] { return going = going && goOn(done); };
    const auto advance = [&](double rounds) {
      done = std::max(done, std::min(1.0, share(clean, kCleanRounds) + rounds / kCleanRounds));
      return keepGoing();
    };
    RelaxedBody body(piece.network);
    const std::size_t rounds = clean == 0 ? 1 : std::min(kCleanRounds - clean, kMaxRounds - round);
    WrongShapes wrong = releaseInRounds(body, round, rounds, trials, advance);
    if (!going) return;
    round += wrong.cleanRounds, clean += wrong.cleanRounds;
    if (wrong.shapes.empty()) continue;
    for (const Example& e : wrong.shapes) ++trials.failures[static_cast<std::size_t>(e.kind)];
    const std::uint64_t seed = settings.seed + (static_cast<std::uint64_t>(round) << 16);
    braceExamples(piece, std::move(wrong.shapes), seed, trials, keepGoing);
    ++round, clean = 0;
  }
}

/// Ratio of thickness and size below which a piece counts as flat.
constexpr double kFlatPiece = 1e-3;

/// Chords per point below which an open piece counts as a piece without an inside.
constexpr double kMinChords = 0.125;

/// Fraction of a piece's braces that soft modes may use. Thin rods stay soft with any number of braces;
/// without this limit, no braces would be left for large deformations.
constexpr double kShareForModes = 0.75;
constexpr double kRounding = 1e-6;  // 0.7 x 90 springs are 63, not 62

/// Returns the ratio of the root mean square distances from the best plane and from the centre.
double thickness(const std::vector<Eigen::Vector3d>& points) {
  const Eigen::Vector3d scatter = principalSpread(points).scatter;
  return scatter.sum() > 0.0 ? std::sqrt(std::max(0.0, scatter[0]) / scatter.sum()) : 0.0;
}

/// With a lower weight, a body is a skin that is stiff against bending around a soft inside. The arms of an L
/// resist opening 1.6 times as much as those of a solid of the same bulk modulus at 0.3, and 1.4 times at
/// 0.5.
constexpr double kPipelineWeight = 0.5;

}  // namespace

double braceWeight(const NetworkSettings& settings) {
  return settings.braceWeight.value_or(settings.braces == BraceRule::Pipeline ? kPipelineWeight : 1.0);
}

std::vector<Edge> bracePiece(const SpringNetwork& piece, const NetworkSettings& settings,
                             const Progress& goOn) {
  const std::size_t points = piece.restPoints.size();
  if (thickness(piece.restPoints) < kFlatPiece) return findTwoRingPairs(piece);
  if (!goOn("bracing: chords", 0.0)) return {};
  const double pairs = 0.5 * static_cast<double>(points) * static_cast<double>(points - 1);
  const double maxBraces =
      std::min(settings.maxBracesPerPoint * static_cast<double>(points) + kRounding, pairs);
  SpringNetwork outward = piece;  // also of a piece that bounds a hollow
  if (signedVolume(piece.restPoints, piece.surface) < 0.0)
    flip(outward.surface, std::vector<bool>(piece.surface.size(), true));
  BracedPiece braced{std::move(outward), braceWeight(settings), static_cast<std::size_t>(maxBraces)};
  addAntipodalBraces(braced);
  const bool fewChords = static_cast<double>(braced.braces.size()) < kMinChords * static_cast<double>(points);
  if (fewChords && !findEdgeDefects(piece.surface).none()) return findTwoRingPairs(piece);
  const auto modeBraces = static_cast<std::size_t>(kShareForModes * maxBraces);
  addSoftModeBraces(braced, modeBraces, settings.seed,
                    [&](double done) { return goOn("bracing: soft modes", done); });
  addCounterexampleBraces(braced, settings, [&](double done) { return goOn("bracing: wrong shapes", done); });
  std::sort(braced.braces.begin(), braced.braces.end());
  return braced.braces;
}

}  // namespace limber
