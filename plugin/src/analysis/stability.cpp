// SPDX-License-Identifier: Zlib
// Measures the stability of a body of a network against large deformations, its time steps, and how stiff it
// must be to stand under its own weight.

#include "analysis/analysis.h"

#include "mesh/linear_algebra.h"
#include "mesh/random.h"
#include "mesh/surface.h"
#include "network/stability.h"
#include "solver/stepping_choice.h"

namespace limber {

// --- deformations and time steps ---------------------------------------------------------------------------

namespace {

/// How a run ended.
enum class RunEnd : std::uint8_t { Skipped, Returned, Mirrored, Wrong };

RunEnd endOf(const RelaxedBody& body, const Points& x) {
  if (distanceToRest(body, x) < kReturned) return RunEnd::Returned;
  return distanceToRest(body, -x) < kReturned ? RunEnd::Mirrored : RunEnd::Wrong;
}

ReturnRate rateOf(const std::vector<RunEnd>& ends) {
  const auto count = [&](RunEnd end) {
    return static_cast<std::uint32_t>(std::count(ends.begin(), ends.end(), end));
  };
  const auto runs = static_cast<std::uint32_t>(ends.size()) - count(RunEnd::Skipped);
  return {runs, count(RunEnd::Returned), count(RunEnd::Mirrored)};
}

}  // namespace

std::uint64_t measuringSeed(std::uint64_t seed) { return seed ^ 0x6d65617375726564u; }  // "measured"

ReturnRate measureReturns(const SpringNetwork& network, Deformation kind, std::uint32_t runs,
                          std::uint64_t seed, const Progress& progress, const ParallelFor& parallel) {
  RelaxedBody body(network);
  if (!canRelax(body)) return {};
  std::vector<RunEnd> ends(runs, RunEnd::Skipped);
  std::atomic<std::uint32_t> finished{0};
  const std::thread::id caller = std::this_thread::get_id();
  relax(
      body, runs, [&](std::size_t run) { return deform(body.rest, kind, measuringSeed(seed), run); },
      [&](std::size_t run, const Points& x) {
        ends[run] = endOf(body, x);
        const double done = static_cast<double>(++finished) / runs;
        const bool goOn = !progress || std::this_thread::get_id() != caller || progress("return rate", done);
        return goOn ? kAllStarts : 0;
      },
      parallel);
  return rateOf(ends);
}

TimeSteps timeSteps(const SpringNetwork& network, const SoftBodySettings& settings) {
  constexpr double kResidual = 1e-5;  // relative to the eigenvalue, whose own error is the square of that
  const auto stepOf = [](double frequencySquared) {
    return frequencySquared > 0.0 ? 2.0 / std::sqrt(frequencySquared) : HUGE_VAL;
  };
  const PointState state = restState(network, settings);
  BodyTerms terms(network, settings);
  const double fastest =
      fastestOscillationSquared(terms.springs, terms.volumes, terms.tetrahedra, state, kResidual);
  return {stepOf(fastest), stepOf(boundSquared(terms, state))};
}

// --- standing ----------------------------------------------------------------------------------------------

namespace {

// The search, in loads m g / (k L).
constexpr double kFirstLoad = 0.02;  // for one point; n layers of a solid body sink by n times as much each
constexpr double kMinLoad = 1e-3;    // of the first one
constexpr double kMaxLoad = 100.0;
constexpr double kLoadFactor =
    1.5;  // between two loads at most: a body that falls may stand again under larger ones
constexpr double kStiffFactor = 3.0;       // between two loads in search of the stiff stance
constexpr double kPrecision = 1.01;        // of the load
constexpr double kHeightPrecision = 5e-4;  // of the height; 1 % of the load sinks a body by 1e-3 more

// The motion, in steps of 1.
constexpr double kMassMargin = 2.0;    // of the masses above the least stable ones
constexpr double kMaxFrequency = 0.9;  // for drag, per step
constexpr double kMinFrequency = 0.1;  // relative to that of toppling, sqrt(weight / masses)
constexpr double kCalmSpeed = 1e-4;    // of the height, per 1/frequency: at rest, if it lasts
constexpr int kCalmSteps = 20;
constexpr double kFriction = 0.25;     // of two bodies with default settings
constexpr double kTilt = 0.01;         // rad, and
constexpr double kNoise = 0.003;       // of the mean spring, so that no body stays in an unstable equilibrium
constexpr double kMinHeight = 1e-3;    // of the size: flatter bodies have nothing to sink by
constexpr double kStiffHeight = 0.98;  // of the height, of a body that counts as stiff
constexpr double kSunk = 0.4;          // of the height, from which a body does not recover
constexpr std::size_t kMaxSteps = 1'000'000, kStepsBetweenChecks = 64;

/// Heaviest over lightest mass. A body with a larger ratio needs too many steps until it rests.
constexpr double kMaxMassRatio = 1e6;

/// A body in unit size, with springs of unit stiffness, above the floor y = 0. Its masses are not its own:
/// they are such that all its points need the same time step, 1.
struct StandingBody {
  PointState state;
  BodyTerms terms;
  Points rest;
  Points supported;           ///< at rest under the largest load that it supports so far
  Eigen::RowVectorXd mass;    ///< of the motion
  Eigen::RowVectorXd weight;  ///< at load 1; 1 on average
  double height = 0.0;        ///< at rest
  std::function<bool()> goOn;
  std::size_t steps = 0;  ///< so far
  bool aborted = false;   ///< too many steps, or ended by `goOn`
};

SoftBodySettings unitSettings(SoftBodySettings settings, double size, std::size_t points) {
  const double stiffness = settings.extensionStiffness;
  settings.scale.setConstant(1.0 / size);
  settings.totalMass = static_cast<double>(points);
  settings.compressionStiffness /= stiffness;
  settings.extensionStiffness = 1.0;
  settings.damping = settings.pressure = settings.ambientPressure = 0.0;
  if (settings.volumeModulus) *settings.volumeModulus *= size / stiffness;
  return settings;
}

/// Adds the row sums of the norms of the blocks of  s g g^T  to the points' sums.
template <class Add>
void addRowSums(const Eigen::Ref<const Points>& gradient, double stiffness, Add add) {
  const Eigen::RowVectorXd norms = gradient.colwise().norm();
  for (Eigen::Index i = 0; i < norms.size(); ++i) add(i, stiffness * norms[i] * norms.sum());
}

/// Returns the row sums of the norms of the blocks of the stiffness matrix.
Eigen::RowVectorXd stiffnessSums(const BodyTerms& terms, const PointState& state) {
  Eigen::RowVectorXd sums = Eigen::RowVectorXd::Zero(state.position.cols());
  const SpringConstants& springs = *terms.springs.original;
  for (std::size_t s = 0; s < springs.a.size(); ++s)
    for (const std::uint32_t end : {springs.a[s], springs.b[s]})
      sums[end] += 2.0 * std::max(springs.extensionStiffness[s], springs.compressionStiffness[s]);
  Points gradient;
  for (std::size_t c = 0; c < terms.volumes->restVolume.size(); ++c) {
    const double stiffness = volumeSlope(terms.volumes, c, state, gradient).stiffness;
    addRowSums(gradient, stiffness, [&](Eigen::Index i, double sum) { sums[i] += sum; });
  }
  for (std::size_t t = 0; t < terms.tetrahedra->tetrahedra.size(); ++t) {
    const TetrahedronSlope slope = tetrahedronSlope(terms.tetrahedra, t, state.position);
    const Tetrahedron& corners = terms.tetrahedra->tetrahedra[t];
    addRowSums(slope.gradient, slope.stiffness,
               [&](Eigen::Index i, double sum) { sums[corners[static_cast<std::size_t>(i)]] += sum; });
  }
  return sums;
}

double heightOf(const Points& position) { return position.row(1).maxCoeff() - position.row(1).minCoeff(); }

/// Returns the rest points, tilted a little, each moved a little, the lowest one on the floor.
Points perturbed(const StandingBody& body) {
  const Eigen::Vector3d axis = Eigen::Vector3d(0.6, 0.0, 0.8);
  Points x = Eigen::AngleAxisd(kTilt, axis).toRotationMatrix() * body.rest;
  const std::vector<double>& lengths = body.terms.springs->restLength;
  double noise = 0.0;
  for (const double length : lengths) noise += kNoise * length / static_cast<double>(lengths.size());
  Random random(1);
  for (double& coordinate : x.reshaped()) coordinate += noise * (random.uniform() - 0.5);
  x.row(1).array() -= x.row(1).minCoeff();
  return x;
}

/// Returns the smallest one above 0; 0 if there is none.
double smallestPositive(const Eigen::RowVectorXd& values) {
  const double none = values.maxCoeff();
  return (values.array() > 0.0).select(values, none).minCoeff();
}

StandingBody makeStanding(const SpringNetwork& network, const SoftBodySettings& settings) {
  StandingBody body{restState(network, settings), {network, settings}, {}, {}, {}, {}, 0.0, {}};
  body.rest = body.state.position;
  body.height = heightOf(body.rest);
  body.weight = body.state.inverseMass.row(0).cwiseInverse();
  // a point of stiffness row sum S moves with at most  omega^2 = S / m;  steps of 1 are stable below 4
  body.mass = 0.25 * kMassMargin * stiffnessSums(body.terms, body.state);
  const double lightest = smallestPositive(body.mass);
  body.aborted = !(lightest > 0.0 && body.mass.maxCoeff() <= kMaxMassRatio * lightest);
  body.mass = body.mass.cwiseMax(lightest);  // points without springs
  body.state.inverseMass = body.mass.cwiseInverse().replicate(3, 1);
  return body;
}

/// Counts a step and returns whether it may be made.
bool mayStep(StandingBody& body) {
  const bool checksProgress = body.goOn && body.steps % kStepsBetweenChecks == 0;
  body.aborted = body.aborted || ++body.steps > kMaxSteps || (checksProgress && !body.goOn());
  return !body.aborted;
}

/// Stops points that would pass the floor, and reduces their speed along it by friction (Coulomb).
void touchFloor(PointState& state) {
  for (Eigen::Index i = 0; i < state.position.cols(); ++i) {
    auto v = state.velocity.col(i);
    const double stop = -state.position(1, i) - v.y();
    if (stop <= 0.0) continue;
    const double along = std::hypot(v.x(), v.z());
    const double speedFactor = along > 0.0 ? std::max(0.0, 1.0 - kFriction * stop / along) : 0.0;
    v.x() *= speedFactor;
    v.z() *= speedFactor;
    v.y() += stop;
  }
}

/// Returns the height that the rest shape has in the body's present orientation.
double undeformedHeight(const StandingBody& body) {
  return heightOf(rigidMotionBetween(body.rest, body.state.position).linear() * body.rest);
}

/// Adds a step of the motion under the load, with drag that damps oscillations of this frequency critically.
void step(StandingBody& body, double load, double frequency) {
  PointState& p = body.state;
  const double drag = 2.0 * frequency;
  p.velocity = ((2.0 - drag) * p.velocity + 2.0 * p.force.cwiseProduct(p.inverseMass)) / (2.0 + drag);
  p.velocity.row(1) -= 2.0 * load / (2.0 + drag) * body.weight.cwiseProduct(p.inverseMass.row(1));
  touchFloor(p);
  p.position += p.velocity;
}

/// Lets the body sink until it rests, or is lower than `minHeight`, and returns its height. The drag damps
/// the frequency of the present motion critically, Rayleigh's quotient of its velocity (P. Underwood,
/// "Dynamic relaxation", 1983). So fast motions end first, and then the slow ones.
double settle(StandingBody& body, double load, double minHeight) {
  SolverBody stepped = solverBody(body.terms, body.state);
  prepareVolumes(stepped, 1.0);
  PointState& p = body.state;
  p.velocity.setZero();
  const double masses = body.mass.sum(), toppling = std::sqrt(load * body.weight.sum() / masses);
  double frequency = toppling;
  int calmSteps = 0;
  while (calmSteps < kCalmSteps || calmSteps * frequency < 1.0) {
    if (!mayStep(body)) return 0.0;
    const Points earlier = p.force;
    computeElasticForces(stepped);
    const double kinetic = (p.velocity.colwise().squaredNorm() * body.mass.transpose()).value();
    const double squared = kinetic > 0.0 ? -p.velocity.cwiseProduct(p.force - earlier).sum() / kinetic : 0.0;
    frequency = std::clamp(std::sqrt(std::max(squared, 0.0)), kMinFrequency * toppling, kMaxFrequency);
    step(body, load, frequency);
    // fast motions of small amplitude must not hide that the body begins to topple
    const double calm = kCalmSpeed * body.height * std::min(frequency, toppling);
    calmSteps = kinetic < calm * calm * masses ? calmSteps + 1 : 0;
    if (heightOf(p.position) < minHeight) break;
  }
  return heightOf(p.position);
}

/// A load and the height under it: relative to that of a stiff body, or to the height that the rest shape has
/// in the present orientation if that is larger. So neither a body that has toppled stands nor one that leans
/// over.
struct Stance {
  double load, height;
  bool stands() const { return height >= kStandingHeight; }
};

/// Returns the stance under a load that is larger than any that the body supported before.
Stance stanceUnder(StandingBody& body, double load) {
  body.state.position = body.supported;
  const Stance stance{
      load, settle(body, load, kSunk * body.height) / std::max(body.height, undeformedHeight(body))};
  if (stance.stands()) body.supported = body.state.position;
  return stance;
}

/// Finds the stance of a stiff body, which may have toppled or rolled: that under a load so small that the
/// body is hardly deformed, or under the least one. Sets the height to that of the rest shape in this
/// orientation.
Stance stiffStance(StandingBody& body) {
  const double heightAtStart = body.height;
  const double first = kFirstLoad / std::pow(static_cast<double>(body.rest.cols()), 2.0 / 3.0);
  Stance stance{kStiffFactor * first, 0.0};
  while (stance.height < kStiffHeight && stance.load >= kMinLoad * first && !body.aborted) {
    body.state.position = perturbed(body);
    stance.load /= kStiffFactor;
    body.height = heightAtStart;
    const double height = settle(body, stance.load, 0.0);
    body.height = std::max(undeformedHeight(body), kMinHeight);
    stance.height = height / body.height;
  }
  body.supported = body.state.position;
  return stance;
}

/// Returns a load between the two, by linear interpolation or in the middle.
double loadBetween(const Stance& low, const Stance& high, bool interpolates) {
  if (!interpolates) return std::sqrt(low.load * high.load);
  const double share = (low.height - kStandingHeight) / (low.height - high.height);
  return low.load + std::clamp(share, 0.05, 0.95) * (high.load - low.load);
}

/// Returns the load under which the body has the standing height: 0 if it sinks further under any load,
/// infinite if it lies flat. The result is meaningless if the body was aborted.
double standingLoad(StandingBody& body) {
  Stance low = stiffStance(body), high{0.0, 0.0};
  if (body.height <= kMinHeight) return HUGE_VAL;
  if (!low.stands()) return 0.0;
  const auto isExact = [](const Stance& s) {
    return std::abs(s.height - kStandingHeight) < kHeightPrecision;
  };
  for (int i = 0; !body.aborted && !isExact(low) && low.load < kMaxLoad; ++i) {
    const bool bracketed = high.load > 0.0;
    if (bracketed && high.load < kPrecision * low.load) break;
    const double sinking = std::max(1.0 - low.height, 1e-3);
    const double next =
        bracketed ? loadBetween(low, high, i % 2 == 0)
                  : low.load * std::clamp((1.0 - kStandingHeight) / sinking, kPrecision, kLoadFactor);
    const Stance stance = stanceUnder(body, next);
    if (isExact(stance)) return next;
    (stance.stands() ? low : high) = stance;
  }
  return low.load;
}

/// Handles a body of one piece, with its scale applied.
std::optional<double> stiffnessOfPiece(const SpringNetwork& network, const SoftBodySettings& settings,
                                       double gravity, const std::function<bool()>& goOn) {
  const std::size_t points = network.restPoints.size();
  const double size = extent(network.restPoints);
  if (network.springs.empty() || !(size > 0.0)) return 0.0;
  StandingBody body = makeStanding(network, unitSettings(settings, size, points));
  body.goOn = goOn;
  const double load = body.aborted ? 0.0 : standingLoad(body);
  if (body.aborted) return std::nullopt;
  const double meanMass = settings.totalMass / static_cast<double>(points);
  return load > 0.0 ? meanMass * gravity / (load * size) : HUGE_VAL;
}

/// Returns the modulus of the whole body: its pieces are of one material.
double volumeModulusOf(const SpringNetwork& network, const SoftBodySettings& settings) {
  const BodyTerms terms(network, settings);
  return std::max(0.0, terms.tetrahedra.empty() ? terms.volumes->modulus : terms.tetrahedra->modulus);
}

}  // namespace

std::optional<double> standingStiffness(const SpringNetwork& network, const SoftBodySettings& settings,
                                        double gravity, const Progress& progress) {
  if (network.springs.empty() || !(gravity > 0.0)) return 0.0;
  if (!(settings.extensionStiffness > 0.0)) return HUGE_VAL;
  SpringNetwork scaled = network;
  for (Eigen::Vector3d& p : scaled.restPoints) p = p.cwiseProduct(settings.scale);
  SoftBodySettings unscaled = settings;
  unscaled.scale.setOnes();
  unscaled.volumeModulus = volumeModulusOf(scaled, unscaled);
  double done = 0.0, largest = 0.0;
  for (const std::vector<std::uint32_t>& points : findPieces(scaled)) {
    SoftBodySettings pieceSettings = unscaled;
    double massFraction = 0.0;
    for (const std::uint32_t i : points) massFraction += scaled.massFractions[i];
    pieceSettings.totalMass *= massFraction;
    const auto goOn = [&] { return !progress || progress("own weight", done); };
    const std::optional<double> ofPiece =
        stiffnessOfPiece(pieceOf(scaled, points), pieceSettings, gravity, goOn);
    if (!ofPiece) return std::nullopt;
    largest = std::max(largest, *ofPiece);
    done += static_cast<double>(points.size()) / static_cast<double>(scaled.restPoints.size());
  }
  return largest;
}

}  // namespace limber
