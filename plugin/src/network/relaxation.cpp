// SPDX-License-Identifier: Zlib
// Deforms bodies of a network and relaxes them: first lightly damped dynamics of many of them at once, then a
// descent to the minimum of the energy.

#include "mesh/linear_algebra.h"
#include "mesh/random.h"
#include "mesh/surface.h"
#include "network/stability.h"
#include "solver/simd_steps.h"
#include "solver/stepping_choice.h"

#include <list>

namespace limber {
namespace {

/// Returns the largest increase (rad^2/s^2) of the square of the fastest frequency by the volume terms in the
/// next `time` seconds.
double volumeBoundSquared(BodyTerms& terms, const PointState& state, double time) {
  return volumeFrequencyBoundSquared(terms.volumes, state, time) +
         tetrahedronFrequencyBoundSquared(terms.tetrahedra, state);
}

}  // namespace

BodyTerms::BodyTerms(const SpringNetwork& network, const SoftBodySettings& settings)
    : springs(makeSprings(network, settings)),
      volumes(makeVolumes(network, settings)),
      tetrahedra(makeTetrahedronVolumes(network, settings)) {}

SolverBody solverBody(BodyTerms& terms, PointState& state) {
  SolverBody body{&state, &terms.springs, nullptr};
  if (!terms.volumes.empty()) body.volumes = &terms.volumes;
  if (!terms.tetrahedra.empty()) body.tetrahedra = &terms.tetrahedra;
  return body;
}

double boundSquared(BodyTerms& terms, const PointState& state) {
  std::vector<double> sums;
  return frequencyBoundSquared(terms.springs, state.inverseMass, sums) +
         volumeBoundSquared(terms, state, 0.0);
}

PointState restState(const SpringNetwork& network, const SoftBodySettings& settings) {
  PointState state;
  state.resize(static_cast<Eigen::Index>(network.restPoints.size()));
  state.position = scaledRest(network, settings.scale);
  for (Eigen::Index i = 0; i < state.position.cols(); ++i)
    state.inverseMass.col(i).setConstant(
        1.0 / (settings.totalMass * network.massFractions[static_cast<std::size_t>(i)]));
  return state;
}

namespace {

SoftBodySettings unitSettings(double size) {
  SoftBodySettings settings;
  settings.scale.setConstant(size > 0.0 ? 1.0 / size : 1.0);
  settings.extensionStiffness = settings.compressionStiffness = 1.0;
  settings.damping = 0.0;
  return settings;
}

/// Returns the sum of the squared distances after the best rigid motion:  sum |x|^2 + |y|^2 - 2 x . R y.
double squaredDistance(const Points& a, const Points& b) {
  const Points x = a.colwise() - a.rowwise().mean(), y = b.colwise() - b.rowwise().mean();
  const double largestProduct = symmetricValues(quaternionMatrix(x * y.transpose()))[3];
  return std::max(0.0, x.squaredNorm() + y.squaredNorm() - 2.0 * largestProduct);
}

}  // namespace

RelaxedBody::RelaxedBody(const SpringNetwork& network) : rest(scaledRest(network, Eigen::Vector3d::Ones())) {
  const SoftBodySettings settings = unitSettings(extent(rest));
  rest *= settings.scale.x();
  terms = BodyTerms(network, settings);
  pieces = findPieces(network);
}

double distanceToRest(const RelaxedBody& body, const Points& x) {
  if (!x.allFinite()) return std::numeric_limits<double>::infinity();
  double sum = 0.0;
  for (const std::vector<std::uint32_t>& piece : body.pieces)
    sum += squaredDistance(body.rest(Eigen::all, piece), x(Eigen::all, piece));
  return std::sqrt(sum / static_cast<double>(x.cols()));
}

namespace {

constexpr std::size_t kMaxPairs = 8;         // pairs of steps and changes of the gradient
constexpr std::size_t kArrivalInterval = 8;  // iterations between two calls of `arrived`
constexpr double kArmijo = 1e-4;  // Armijo's constant, fraction of the decrease that the slope predicts
constexpr int kMaxHalvings = 30;

/// A step and the change of the gradient over it.
struct DescentPair {
  Points step, change;
  Points smoothedChange;   ///< inverse Laplacian . change
  double curvature = 0.0;  ///< step . change, above 0
};

/// The gradient of the energy, and the inverse Laplacian times it.
struct Slope {
  Points gradient, smoothed;
};

/// Fraction of the mean diagonal that is added to the Laplacian, so that it has an inverse.
constexpr double kLaplacianShift = 1e-7;

/// Returns the factor of the body's Laplacian: the matrix (#points x #points) of springs with its constants
/// and no rest lengths, and of the volumes of its tetrahedra, each K/V0 g_a . g_b with the gradient g at
/// rest. It does not depend on the body's orientation, and its softest motions are the soft ones of the body
/// (T. Liu, S. Bouaziz, L. Kavan, "Quasi-Newton methods for real-time simulation of hyperelastic materials",
/// 2017).
SparseFactor factoriseLaplacian(const BodyTerms& terms, const Points& rest) {
  std::vector<Eigen::Triplet<double>> entries;
  double trace = 0.0;
  const auto add = [&](std::uint32_t a, std::uint32_t b, double value) {
    entries.emplace_back(static_cast<int>(a), static_cast<int>(b), value);
    if (a == b) trace += value;
  };
  for (std::size_t s = 0; s < terms.springs.size(); ++s) {
    const std::uint32_t a = terms.springs->a[s], b = terms.springs->b[s];
    const double k = terms.springs->extensionStiffness[s];
    add(a, a, k), add(b, b, k), add(a, b, -k), add(b, a, -k);
  }
  for (std::size_t t = 0; !terms.tetrahedra.empty() && t < terms.tetrahedra->tetrahedra.size(); ++t) {
    const Tetrahedron& corners = terms.tetrahedra->tetrahedra[t];
    const TetrahedronSlope slope = tetrahedronSlope(terms.tetrahedra, t, rest);
    const Eigen::Matrix4d products = slope.stiffness * slope.gradient.transpose() * slope.gradient;
    for (Eigen::Index a = 0; a < 4; ++a)
      for (Eigen::Index b = 0; b < 4; ++b)
        add(corners[static_cast<std::size_t>(a)], corners[static_cast<std::size_t>(b)], products(a, b));
  }
  const double shift = trace > 0.0 ? kLaplacianShift * trace / static_cast<double>(rest.cols()) : 1.0;
  for (Eigen::Index i = 0; i < rest.cols(); ++i)
    entries.emplace_back(static_cast<int>(i), static_cast<int>(i), shift);
  Eigen::SparseMatrix<double> laplacian(rest.cols(), rest.cols());
  laplacian.setFromTriplets(entries.begin(), entries.end());
  return factorise(laplacian);
}

/// Returns the inverse of the Laplacian times x.
Points smoothed(const SparseFactor& laplacian, const Points& x) {
  Points rows(3, x.cols());  // a column per point: solveOrdered() takes rows
  for (Eigen::Index i = 0; i < x.cols(); ++i) rows.col(laplacian.place[i]) = x.col(i);
  solveOrdered(laplacian, rows.transpose());
  Points result(3, x.cols());
  for (Eigen::Index i = 0; i < x.cols(); ++i) result.col(i) = rows.col(laplacian.place[i]);
  return result;
}

/// Performs the two-loop recursion: minus the inverse Hessian that the pairs and the Laplacian approximate,
/// times the gradient.
Points direction(const std::vector<DescentPair>& pairs, const Slope& slope) {
  Points d = -slope.gradient, smoothed = -slope.smoothed;
  std::vector<double> share(pairs.size());
  for (std::size_t i = pairs.size(); i-- > 0;) {
    share[i] = dot(pairs[i].step, d) / pairs[i].curvature;
    d -= share[i] * pairs[i].change;
    smoothed -= share[i] * pairs[i].smoothedChange;
  }
  if (!pairs.empty())
    smoothed *= pairs.back().curvature / dot(pairs.back().change, pairs.back().smoothedChange);
  for (std::size_t i = 0; i < pairs.size(); ++i)
    smoothed += (share[i] - dot(pairs[i].change, smoothed) / pairs[i].curvature) * pairs[i].step;
  return smoothed;
}

void storePair(std::vector<DescentPair>& pairs, Points step, const Slope& from, const Slope& to) {
  Points change = to.gradient - from.gradient;
  const double curvature = dot(step, change);
  if (curvature <= 1e-12 * std::sqrt(step.squaredNorm() * change.squaredNorm())) return;
  if (pairs.size() == kMaxPairs) pairs.erase(pairs.begin());
  pairs.push_back({std::move(step), std::move(change), to.smoothed - from.smoothed, curvature});
}

Slope slopeAt(SolverBody& body, const SparseFactor& laplacian) {
  computeElasticForces(body);
  return {-body.points->force, smoothed(laplacian, -body.points->force)};
}

/// Halves the step until the energy falls enough; returns 0 if it never does.
double lineSearch(SolverBody& body, const Points& from, const Points& d, double slope, double& energy) {
  double step = 1.0;
  for (int i = 0; i < kMaxHalvings; ++i, step *= 0.5) {
    body.points->position = from + step * d;
    const double newEnergy = elasticEnergy(body, body.points->position);
    if (newEnergy > energy + kArmijo * step * slope) continue;
    energy = newEnergy;
    return step;
  }
  body.points->position = from;
  return 0.0;
}

/// Moves the points downhill to a minimum of the elastic energy, by L-BFGS (Liu and Nocedal 1989) from the
/// inverse Laplacian. Ends when the largest force on a point is below `minForce` (N), when `arrived` returns
/// true for the positions, or after `iterations`.
void descend(SolverBody& body, const SparseFactor& laplacian, double minForce, std::size_t iterations,
             const std::function<bool(const Points&)>& arrived) {
  std::vector<DescentPair> pairs;
  Slope slope = slopeAt(body, laplacian);
  double energy = elasticEnergy(body, body.points->position);
  for (std::size_t i = 0; i < iterations; ++i) {
    if (slope.gradient.cwiseAbs().maxCoeff() < minForce) return;
    if (i % kArrivalInterval == 0 && arrived(body.points->position)) return;
    Points d = direction(pairs, slope);
    if (dot(d, slope.gradient) >= 0.0) {
      pairs.clear();
      d = -slope.smoothed;
    }
    const Points from = body.points->position;
    if (lineSearch(body, from, d, dot(d, slope.gradient), energy) == 0.0) {
      if (pairs.empty()) return;  // rounding prevents any further decrease
      pairs.clear();
      continue;
    }
    const Slope earlier = std::move(slope);
    slope = slopeAt(body, laplacian);
    storePair(pairs, body.points->position - from, earlier, slope);
  }
}

constexpr double kRelaxationDrag = 0.05;  // 1/s, at unit mass and spring constant
constexpr double kStepFraction = 0.75;    // fraction of the stable step at rest
constexpr double kMaxTime = 600.0;        // s; by then drag alone has reduced the energy by 13 powers of ten
constexpr double kMinTime = 10.0;         // s; earlier a slow body does not count as at rest

// Substeps between two checks of a run, which choose its step. There are few while the run is wild: while its
// step must be much smaller than at rest, or its points move far (relative to the size, root mean square)
// between two checks of a calm run. Most checks of a calm run keep its step.
constexpr int kCalmSubsteps = 8, kWildSubsteps = 4;
constexpr int kCalmChecks = 8;
constexpr int kMaxChecks = 20'000;  // then a run that is still wild continues with the descent
constexpr double kWildBound = 1.5;  // times the square of the frequency bound at rest
constexpr double kWildDisplacement = 0.5;
constexpr double kCalmFraction = 0.95, kWildFraction = 0.6;  // fractions of the stable step
constexpr int kMaxStepHalvings = 12;                         // of the step at rest

/// Kinetic energy, J per square of the mean spring length: too small to flip a point through its neighbours.
constexpr double kRestEnergy = 1e-2;
constexpr double kMinForce = 2e-7;  // N, of the descent
constexpr std::size_t kMaxDescent = 3000;

double meanLength(const SpringArrays& springs) {
  double sum = 0.0;
  for (const double length : springs->restLength) sum += length;
  return springs.size() > 0 ? sum / static_cast<double>(springs.size()) : 1.0;
}

/// A start that is being relaxed.
struct Run {
  std::size_t index = 0;
  PointState state;
  double time = 0.0;  ///< s
  int checks = 0;
  int halvings = 0;              ///< of the step at rest
  int substeps = kWildSubsteps;  ///< until the next check
};

/// Eight bodies of some hundred points exceed the second cache; four take less time.
InstructionSet cachedSet() {
  const InstructionSet best = bestInstructionSet();
  return best == InstructionSet::Avx512 ? InstructionSet::Avx2 : best;
}

/// Data that all runs of a body share.
struct Dynamics {
  RelaxedBody& body;
  double springBound;  ///< rad^2/s^2
  double restBound;    ///< rad^2/s^2, with the volume terms
  double step;         ///< s, at rest
  double restEnergy;   ///< J
  InstructionSet set = cachedSet();
  SparseFactor laplacian;
  LaneScratch scratch;
  SpringBatchArrays springBatches;

  explicit Dynamics(RelaxedBody& relaxed) : body(relaxed) {
    const PointState rest = stateAt(body.rest);
    std::vector<double> sums;
    springBound = frequencyBoundSquared(body.terms.springs, rest.inverseMass, sums);
    restBound = boundSquared(rest, 0.0);
    step = restBound > 0.0 ? kStepFraction * 2.0 / std::sqrt(restBound) : 1.0;
    laplacian = factoriseLaplacian(body.terms, body.rest);
    const double length = meanLength(body.terms.springs);
    restEnergy = kRestEnergy * length * length;
  }

  static PointState stateAt(const Points& position) {
    PointState state;
    state.resize(position.cols());
    state.position = position;
    state.inverseMass.setOnes();
    return state;
  }
  /// rad^2/s^2, for the next `time` seconds.
  double boundSquared(const PointState& state, double time) {
    return springBound + volumeBoundSquared(body.terms, state, time);
  }
  SolverBody stepped(PointState& state) {
    SolverBody s = solverBody(body.terms, state);
    if (canStepSpringBatches()) s.springBatches = &springBatches;
    return s;
  }
};

bool isWild(const Dynamics& dynamics, const Run& run, double bound) {
  const double squaredSpeed =
      run.state.velocity.squaredNorm() / static_cast<double>(run.state.velocity.cols());
  const double displacement = kCalmSubsteps * dynamics.step;
  return bound > kWildBound * dynamics.restBound ||
         squaredSpeed * displacement * displacement > kWildDisplacement * kWildDisplacement;
}

/// The frequency bound of the volume terms grows with the triangles. Steps are halved repeatedly, see
/// scaleTime().
void chooseStep(Dynamics& dynamics, Run& run) {
  if (run.substeps == kCalmSubsteps && run.checks % kCalmChecks != 0) return;
  const double bound = dynamics.boundSquared(run.state, dynamics.step);
  const bool wild = isWild(dynamics, run, bound);
  const double stable = (wild ? kWildFraction : kCalmFraction) * 2.0 / std::sqrt(bound);
  run.substeps = wild ? kWildSubsteps : kCalmSubsteps;
  run.halvings = 0;
  while (run.halvings < kMaxStepHalvings && std::ldexp(dynamics.step, -run.halvings) > stable) ++run.halvings;
}

/// Expresses velocities and inverse masses in units of 2^halvings s, in which the run's step is as long as
/// the step at rest:  v -> v 2^-halvings,  w -> w 4^-halvings.  Powers of two change no digit, so that runs
/// with different steps share the registers and keep their bits.
void scaleTime(Run& run, int halvings) {
  if (halvings == 0) return;
  run.state.velocity *= std::ldexp(1.0, -halvings);
  run.state.inverseMass *= std::ldexp(1.0, -2 * halvings);
}

/// Steps runs with the same number of substeps. Lanes are faster if at least three are filled.
void stepTogether(Dynamics& dynamics, Run* const* runs, std::size_t count) {
  const int substeps = runs[0]->substeps;
  const double time = substeps * dynamics.step;
  if (count < 3 || laneCount(dynamics.set) < 3) {
    for (std::size_t i = 0; i < count; ++i) {
      SolverIsland island;
      island.bodies.push_back(dynamics.stepped(runs[i]->state));
      stepVerlet(island, time, substeps);
    }
    return;
  }
  std::vector<SolverBody> bodies;
  for (std::size_t lane = 0; lane < count; ++lane) bodies.push_back(dynamics.stepped(runs[lane]->state));
  std::vector<SolverBody*> lanes;
  lanes.reserve(count);
  for (SolverBody& body : bodies) lanes.push_back(&body);
  stepLanes(lanes.data(), count, dynamics.scratch, time, substeps, dynamics.set);
}

void stepAll(Dynamics& dynamics, std::list<Run>& runs) {
  for (Run& run : runs) scaleTime(run, run.halvings);
  for (const int substeps : {kCalmSubsteps, kWildSubsteps}) {
    std::vector<Run*> group;
    for (Run& run : runs)
      if (run.substeps == substeps) group.push_back(&run);
    const auto lanes = static_cast<std::size_t>(laneCount(dynamics.set));
    for (std::size_t i = 0; i < group.size(); i += lanes)
      stepTogether(dynamics, &group[i], std::min(lanes, group.size() - i));
  }
  for (Run& run : runs) scaleTime(run, -run.halvings);
}

/// Also returns true for runs with NaN.
bool hasCalmedDown(const Dynamics& dynamics, const Run& run) {
  if (run.checks >= kMaxChecks || run.time >= kMaxTime) return true;
  return run.time >= kMinTime && !(0.5 * run.state.velocity.squaredNorm() >= dynamics.restEnergy);
}

/// Does not limit the volume terms, as a stable step would require: forces that are not the gradient of the
/// energy would misdirect the descent.
void descendToMinimum(Dynamics& dynamics, Run& run) {
  SolverBody stepped = dynamics.stepped(run.state);
  prepareVolumes(stepped, 0.0);
  const double maxDistance = 0.5 * kReturned;
  descend(stepped, dynamics.laplacian, kMinForce, kMaxDescent,
          [&](const Points& x) { return distanceToRest(dynamics.body, x) < maxDistance; });
}

// Wild and calm runs fill the lanes separately, so there are several times as many runs as lanes.
constexpr std::size_t kMaxRuns = 16, kMinRuns = 8;  // at a time, of a task
constexpr std::size_t kRunsPerTask = 24, kMaxTasks = 8;

/// Starts that the tasks of relax() share: each takes the next one when it has room.
struct Starts {
  std::atomic<std::size_t> next{0}, wanted;
  const std::function<Points(std::size_t)>& at;
  const std::function<std::size_t(std::size_t, const Points&)>& finish;

  void limit(std::size_t count) {
    std::size_t now = wanted;
    while (count < now && !wanted.compare_exchange_weak(now, count)) {
    }
  }
};

void takeStarts(Starts& starts, std::list<Run>& runs, std::size_t maxRuns) {
  while (runs.size() < maxRuns && starts.next < starts.wanted) {
    Run run;
    run.index = starts.next++;
    if (run.index >= starts.wanted) return;
    run.state = Dynamics::stateAt(starts.at(run.index));
    runs.push_back(std::move(run));
  }
}

/// Steps all runs to their next checks, and finishes those at rest.
void advance(Dynamics& dynamics, std::list<Run>& runs, Starts& starts) {
  for (Run& run : runs) chooseStep(dynamics, run);
  stepAll(dynamics, runs);
  for (auto run = runs.begin(); run != runs.end();) {
    const double time = run->substeps * std::ldexp(dynamics.step, -run->halvings);
    run->time += time;
    ++run->checks;
    run->state.velocity /= 1.0 + kRelaxationDrag * time;
    if (!hasCalmedDown(dynamics, *run)) {
      ++run;
      continue;
    }
    if (run->index < starts.wanted) {
      descendToMinimum(dynamics, *run);
      starts.limit(starts.finish(run->index, run->state.position));
    }
    run = runs.erase(run);
  }
  runs.remove_if([&](const Run& run) { return run.index >= starts.wanted; });
}

void relaxStarts(RelaxedBody& body, Starts& starts, std::size_t maxRuns) {
  Dynamics dynamics(body);
  std::list<Run> runs;
  do {
    takeStarts(starts, runs, maxRuns);
    advance(dynamics, runs, starts);
  } while (!runs.empty() || starts.next < starts.wanted);
}

}  // namespace

bool canRelax(RelaxedBody& body) { return kMaxChecks * kCalmSubsteps * Dynamics(body).step >= kMinTime; }

void relax(RelaxedBody& body, std::size_t count, const std::function<Points(std::size_t)>& start,
           const std::function<std::size_t(std::size_t, const Points&)>& finish,
           const ParallelFor& parallel) {
  Starts starts{{0}, {count}, start, finish};
  if (!parallel || count < 2 * kMinRuns) return relaxStarts(body, starts, kMaxRuns);
  const std::size_t tasks = std::clamp<std::size_t>(count / kRunsPerTask, 2, kMaxTasks);
  parallel(tasks, [&](std::size_t) {
    RelaxedBody own = body;
    relaxStarts(own, starts, std::min(kMaxRuns, (count + tasks - 1) / tasks));
  });
}

namespace {

// Lengths as fractions of the size.
constexpr double kSquashScale = 0.1, kNoise = 0.5, kPushDistance = 0.2, kSlab = 0.3, kPerturbation = 1e-4;

using Direction = Eigen::Vector3d;

/// Range of the points' coordinates along a direction (m).
struct Range {
  double low, high;
};

Range rangeAlong(const Points& x, const Direction& d) {
  const Eigen::RowVectorXd along = d.transpose() * x;
  return {along.minCoeff(), along.maxCoeff()};
}

void squash(Points& x, const Direction& d, double scale) {
  const Eigen::Vector3d centre = x.rowwise().mean();
  for (Eigen::Index i = 0; i < x.cols(); ++i)
    x.col(i) -= (1.0 - scale) * d.dot(Eigen::Vector3d(x.col(i)) - centre) * d;
}

/// Rotates by the angle  2 atan(u), u from 0 at one end to 1 at the other:  from zero to a quarter turn,
/// nearly evenly. It uses no sine, whose last bits differ between C libraries.
void twist(Points& x, const Direction& axis) {
  const Eigen::Vector3d centre = x.rowwise().mean();
  const Range range = rangeAlong(x, axis);
  for (Eigen::Index i = 0; i < x.cols(); ++i) {
    const double u = range.high > range.low ? (axis.dot(x.col(i)) - range.low) / (range.high - range.low) : 0;
    const double sine = 2.0 * u / (1.0 + u * u), cosine = (1.0 - u * u) / (1.0 + u * u);
    const Eigen::Vector3d r = Eigen::Vector3d(x.col(i)) - centre;
    const Eigen::Vector3d along = axis.dot(r) * axis, across = r - along;
    x.col(i) = centre + along + cosine * across + sine * axis.cross(across);
  }
}

void moveAll(Points& x, double distance, Random& random) {
  for (Eigen::Index i = 0; i < x.cols(); ++i) x.col(i) += distance * random.inBall();
}

/// Flips the direction if necessary, so that it points from the point to the body's centre.
void push(Points& x, Eigen::Index point, Direction d, double size) {
  if (d.dot(Eigen::Vector3d(x.rowwise().mean()) - x.col(point)) < 0.0) d = -d;
  x.col(point) += (rangeAlong(x, d).high + kPushDistance * size - d.dot(x.col(point))) * d;
}

void mirrorSlab(Points& x, const Direction& d) {
  const Range range = rangeAlong(x, d);
  const double cut = range.high - kSlab * (range.high - range.low);
  for (Eigen::Index i = 0; i < x.cols(); ++i) {
    const double beyond = d.dot(x.col(i)) - cut;
    if (beyond > 0.0) x.col(i) -= 2.0 * beyond * d;
  }
}

void invert(Points& x) {
  const Eigen::Vector3d centre = x.rowwise().mean();
  for (Eigen::Index i = 0; i < x.cols(); ++i) x.col(i) = 2.0 * centre - x.col(i);
}

void deformBy(Deformation kind, double size, Points& x, Random& random) {
  const Direction d = random.direction();
  switch (kind) {
    case Deformation::Squash:
      return squash(x, d, kSquashScale);
    case Deformation::Twist:
      return twist(x, d);
    case Deformation::Noise:
      return moveAll(x, kNoise * size, random);
    case Deformation::Push:
      return push(x, random.below(static_cast<std::size_t>(x.cols())), d, size);
    case Deformation::Mirror:
      return mirrorSlab(x, d);
    case Deformation::Flatten:
      return squash(x, d, 0.0);
    case Deformation::Inversion:
      return invert(x);
  }
}

Random randomOf(Deformation kind, std::uint64_t seed, std::uint64_t run) {
  Random mixed(seed);
  Random perKind(mixed.next() ^ (static_cast<std::uint64_t>(kind) + 1));
  return Random(perKind.next() ^ run);
}

}  // namespace

Points deform(const Points& rest, Deformation kind, std::uint64_t seed, std::uint64_t run) {
  Random random = randomOf(kind, seed, run);
  const double size = extent(rest);
  Points x = rest;
  deformBy(kind, size, x, random);
  moveAll(x, kPerturbation * size, random);
  return x;
}

}  // namespace limber
