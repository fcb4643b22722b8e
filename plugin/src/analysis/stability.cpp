// SPDX-License-Identifier: Zlib
// Measures the stability of a body of a network against large deformations and its own weight, and its time
// steps.

#include "analysis/analysis.h"

#include "mesh/random.h"
#include "mesh/surface.h"
#include "network/modes.h"
#include "network/relaxation.h"
#include "solver/springs.h"
#include "solver/stepping_choice.h"
#include "solver/verlet_step.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <functional>

namespace limber {
namespace {

void count(ReturnRate& rate, const RelaxedBody& body, const Points& x) {
  ++rate.runs;
  if (distanceToRest(body, x) < kReturned)
    ++rate.returned;
  else if (distanceToRest(body, -x) < kReturned)
    ++rate.mirrored;
}

}  // namespace

std::uint64_t measuringSeed(std::uint64_t seed) { return seed ^ 0x6d65617375726564u; }  // "measured"

ReturnRate measureReturns(const SpringNetwork& network, Deformation kind, std::uint32_t runs,
                          std::uint64_t seed, const Progress& progress) {
  RelaxedBody body(network);
  ReturnRate rate;
  if (!canRelax(body)) return rate;
  relax(
      body, runs, [&](std::size_t run) { return deform(body.rest, kind, measuringSeed(seed), run); },
      [&](std::size_t, const Points& x) {
        count(rate, body, x);
        return !progress || progress("return rate", static_cast<double>(rate.runs) / runs);
      });
  return rate;
}

namespace {

constexpr double kResidual = 1e-5;  // relative to the eigenvalue, whose own error is the square of that

double stepOf(double frequencySquared) {
  return frequencySquared > 0.0 ? 2.0 / std::sqrt(frequencySquared) : HUGE_VAL;
}

}  // namespace

TimeSteps timeSteps(const SpringNetwork& network, const SoftBodySettings& settings) {
  const PointState state = restState(network, settings);
  BodyTerms terms(network, settings);
  const double fastest =
      fastestOscillationSquared(terms.springs, terms.volumes, terms.tetrahedra, state, kResidual);
  return {stepOf(fastest), stepOf(boundSquared(terms, state))};
}

namespace {

// The search, in loads m g / (k L).
constexpr double kMinLoad = 1e-6, kFirstLoad = 1e-3, kMaxLoad = 20.0;
constexpr double kLoadFactor = 1.6;  // small: a body can return by chance from a much larger load
constexpr double kPrecision = 1.04;

// The motion, in units of the size, the mean mass of a point and the stiffness.
constexpr double kMaxDrag = 0.1;  // limit, besides sqrt(load): a larger drag would support toppling bodies
constexpr double kFriction = 0.5;
constexpr double kSafeStepFraction = 0.5;  // fraction of the safe step
constexpr double kSettlingTime = 300.0;    // limit: drag reduces the energy by 13 powers of ten
constexpr double kFallTimes = 20.0;  // limit, in 1/sqrt(load), if longer: perturbations grow by e in 1.6
constexpr double kCalmSpeed = 1e-3;  // root mean square, relative to the load: at rest, if it lasts
constexpr int kCalmSteps = 20;
constexpr double kStartPerturbation = 1e-3;  // of the start, so that no body stays in an unstable equilibrium

// Common bodies take some hundred thousand steps for all loads together.
constexpr std::size_t kMaxStandingSteps = 4'000'000;
constexpr std::size_t kStepsBetweenProgress = 256;

// Conditions for a body that stands.
constexpr double kMinStandingHeight = 0.5;  // relative to the height at rest
constexpr double kMaxDistance = 0.05;       // from the rest shape afterwards: dents are allowed

/// The body in unit size, its lowest point on the floor y = 0.
struct StandingBody {
  RelaxedBody shape;
  PointState state;
  BodyTerms terms;
  Points rest;
  double step = 0.0;
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
  settings.damping = settings.pressure = 0.0;
  if (settings.volumeModulus) *settings.volumeModulus *= size / stiffness;
  return settings;
}

StandingBody makeStanding(const SpringNetwork& network, const SoftBodySettings& settings) {
  StandingBody body{RelaxedBody(network), restState(network, settings), {network, settings}, {}, 0.0, {}};
  body.state.position.row(1).array() -= body.state.position.row(1).minCoeff();
  body.rest = body.state.position;
  body.step = kSafeStepFraction * 2.0 / std::sqrt(boundSquared(body.terms, body.state));
  body.aborted = !(kSettlingTime / body.step <= static_cast<double>(kMaxStandingSteps));
  return body;
}

/// Counts a step and returns whether it may be made.
bool mayStep(StandingBody& body) {
  const bool checksProgress = body.goOn && body.steps % kStepsBetweenProgress == 0;
  body.aborted = body.aborted || ++body.steps > kMaxStandingSteps || (checksProgress && !body.goOn());
  return !body.aborted;
}

/// Stops points that would pass the floor, and reduces their speed along it by friction (Coulomb).
void touchFloor(PointState& state, double dt) {
  for (Eigen::Index i = 0; i < state.position.cols(); ++i) {
    auto v = state.velocity.col(i);
    const double stop = -state.position(1, i) / dt - v.y();
    if (stop <= 0.0) continue;
    const double along = std::hypot(v.x(), v.z());
    const double speedFactor = along > 0.0 ? std::max(0.0, 1.0 - kFriction * stop / along) : 0.0;
    v.x() *= speedFactor;
    v.z() *= speedFactor;
    v.y() += stop;
  }
}

/// Moves the body until it rests.
void moveUntilRest(StandingBody& body, double gravity, double maxTime, double calmSpeed) {
  SolverBody stepped = solverBody(body.terms, body.state);
  prepareVolumes(stepped, body.step);
  PointState& p = body.state;
  p.velocity.setZero();
  const double drag = gravity > 0.0 ? std::min(kMaxDrag, std::sqrt(gravity)) : kMaxDrag;
  const double dt = body.step, dragFactor = std::exp(-drag * dt);
  const double calm = calmSpeed * calmSpeed * static_cast<double>(p.position.cols());
  int calmSteps = 0;
  for (double time = 0.0; time < maxTime && calmSteps < kCalmSteps && mayStep(body); time += dt) {
    computeElasticForces(stepped);
    p.velocity = dragFactor * (p.velocity + dt * p.force.cwiseProduct(p.inverseMass));
    p.velocity.row(1).array() -= dt * gravity;
    if (gravity > 0.0) touchFloor(p, dt);
    p.position += dt * p.velocity;
    calmSteps = p.velocity.squaredNorm() < calm ? calmSteps + 1 : 0;
  }
}

double heightOf(const Points& position) { return position.row(1).maxCoeff() - position.row(1).minCoeff(); }

/// Returns the height divided by that of the rest shape in the body's present orientation. So a body that has
/// toppled but kept its shape has not collapsed.
double relativeHeight(const StandingBody& body) {
  const Eigen::Matrix4d transform = Eigen::umeyama(body.rest, body.state.position, false);
  return heightOf(body.state.position) / heightOf(transform.topLeftCorner<3, 3>() * body.rest);
}

bool supportsLoad(StandingBody& body, double load) {
  Random random(1);
  Points& position = body.state.position;
  position = body.rest;
  for (double& x : position.reshaped()) x += kStartPerturbation * (random.uniform() - 0.5);
  position.row(1).array() -= position.row(1).minCoeff();
  const double maxTime = std::max(kSettlingTime, kFallTimes / std::sqrt(load));
  moveUntilRest(body, load, maxTime, kCalmSpeed * load);
  if (body.aborted || !(relativeHeight(body) >= kMinStandingHeight)) return false;
  moveUntilRest(body, 0.0, kSettlingTime, kCalmSpeed * load);
  return !body.aborted && distanceToRest(body.shape, position) < kMaxDistance;
}

/// Returns the largest load below the first that is too large; 0 if all are too large. The result is
/// meaningless if the body was aborted.
double loadLimit(StandingBody& body) {
  double supported = kFirstLoad;
  while (!supportsLoad(body, supported) && !body.aborted)
    if ((supported *= 0.5) < kMinLoad) return 0.0;
  double failing = kLoadFactor * supported;
  while (failing < kMaxLoad && supportsLoad(body, failing)) {
    supported = failing;
    failing *= kLoadFactor;
  }
  while (failing > kPrecision * supported && !body.aborted) {
    const double load = std::sqrt(supported * failing);
    (supportsLoad(body, load) ? supported : failing) = load;
  }
  return supported;
}

/// Handles a body of one piece, with its scale applied.
std::optional<double> minStiffnessOfPiece(const SpringNetwork& network, const SoftBodySettings& settings,
                                          double gravity, const std::function<bool()>& goOn) {
  const std::size_t points = network.restPoints.size();
  const double size = extent(network.restPoints);
  if (network.springs.empty() || !(size > 0.0)) return 0.0;
  StandingBody body = makeStanding(network, unitSettings(settings, size, points));
  body.goOn = goOn;
  const double load = body.aborted ? 0.0 : loadLimit(body);
  if (body.aborted) return std::nullopt;
  const double meanMass = settings.totalMass / static_cast<double>(points);
  return load > 0.0 ? meanMass * gravity / (load * size) : HUGE_VAL;
}

/// Returns the modulus of the whole body: its pieces are of one material.
double volumeModulusOf(const SpringNetwork& network, const SoftBodySettings& settings) {
  const BodyTerms terms(network, settings);
  return std::max(0.0, terms.tetrahedra.empty() ? terms.volumes->modulus : terms.tetrahedra->modulus);
}

/// Returns the largest constant of the pieces.
std::optional<double> minStiffnessOfPieces(const SpringNetwork& network, SoftBodySettings settings,
                                           double gravity, const Progress& progress) {
  double done = 0.0, largest = 0.0;
  settings.volumeModulus = volumeModulusOf(network, settings);
  for (const std::vector<Eigen::Index>& points : findPieces(network)) {
    SoftBodySettings pieceSettings = settings;
    double massFraction = 0.0;
    for (const Eigen::Index i : points) massFraction += network.massFractions[static_cast<std::size_t>(i)];
    pieceSettings.totalMass *= massFraction;
    const auto goOn = [&] { return !progress || progress("own weight", done); };
    const std::optional<double> pieceStiffness =
        minStiffnessOfPiece(pieceOf(network, points), pieceSettings, gravity, goOn);
    if (!pieceStiffness) return std::nullopt;
    largest = std::max(largest, *pieceStiffness);
    done += static_cast<double>(points.size()) / static_cast<double>(network.restPoints.size());
  }
  return largest;
}

}  // namespace

std::optional<double> minStiffness(const SpringNetwork& network, const SoftBodySettings& settings,
                                   double gravity, const Progress& progress) {
  if (network.springs.empty() || !(gravity > 0.0)) return 0.0;
  if (!(settings.extensionStiffness > 0.0)) return HUGE_VAL;
  SpringNetwork scaled = network;
  for (Eigen::Vector3d& p : scaled.restPoints) p = p.cwiseProduct(settings.scale);
  SoftBodySettings unscaled = settings;
  unscaled.scale.setOnes();
  return minStiffnessOfPieces(scaled, unscaled, gravity, progress);
}

}  // namespace limber
