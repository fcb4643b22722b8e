// SPDX-License-Identifier: Zlib
// Measures how a body of a network stands up to large deformations and to its own weight, and which time
// steps it takes.

#include "network/relaxation.h"

#include "mesh/random.h"
#include "mesh/surface.h"
#include "network/rigidity.h"
#include "solver/springs.h"
#include "solver/stepping_choice.h"
#include "solver/verlet_step.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <functional>

namespace limber {
namespace {

// Lengths as shares of the size.
constexpr double kSquashed = 0.1, kNoise = 0.5, kPushedBeyond = 0.2, kSlab = 0.3, kUnevenness = 1e-4;

using Direction = Eigen::Vector3d;

/// How far the points reach along a direction (m).
struct Reach {
  double low, high;
};

Reach reachAlong(const Points& x, const Direction& d) {
  const Eigen::RowVectorXd along = d.transpose() * x;
  return {along.minCoeff(), along.maxCoeff()};
}

void squash(Points& x, const Direction& d, double share) {
  const Eigen::Vector3d centre = x.rowwise().mean();
  for (Eigen::Index i = 0; i < x.cols(); ++i)
    x.col(i) -= (1.0 - share) * d.dot(Eigen::Vector3d(x.col(i)) - centre) * d;
}

/// Turns by the angle  2 atan(u), u from 0 at one end to 1 at the other:  from nothing to a quarter turn,
/// nearly evenly, and without a sine, which differs in its last bits from one C library to the next.
void twist(Points& x, const Direction& axis) {
  const Eigen::Vector3d centre = x.rowwise().mean();
  const Reach reach = reachAlong(x, axis);
  for (Eigen::Index i = 0; i < x.cols(); ++i) {
    const double u = reach.high > reach.low ? (axis.dot(x.col(i)) - reach.low) / (reach.high - reach.low) : 0;
    const double sine = 2.0 * u / (1.0 + u * u), cosine = (1.0 - u * u) / (1.0 + u * u);
    const Eigen::Vector3d r = Eigen::Vector3d(x.col(i)) - centre;
    const Eigen::Vector3d along = axis.dot(r) * axis, across = r - along;
    x.col(i) = centre + along + cosine * across + sine * axis.cross(across);
  }
}

void moveAll(Points& x, double distance, Random& random) {
  for (Eigen::Index i = 0; i < x.cols(); ++i) x.col(i) += distance * random.inBall();
}

/// The direction is turned to the side that the body lies on, seen from the point.
void push(Points& x, Eigen::Index point, Direction d, double size) {
  if (d.dot(Eigen::Vector3d(x.rowwise().mean()) - x.col(point)) < 0.0) d = -d;
  x.col(point) += (reachAlong(x, d).high + kPushedBeyond * size - d.dot(x.col(point))) * d;
}

void mirrorSlab(Points& x, const Direction& d) {
  const Reach reach = reachAlong(x, d);
  const double cut = reach.high - kSlab * (reach.high - reach.low);
  for (Eigen::Index i = 0; i < x.cols(); ++i) {
    const double beyond = d.dot(x.col(i)) - cut;
    if (beyond > 0.0) x.col(i) -= 2.0 * beyond * d;
  }
}

void invert(Points& x) {
  const Eigen::Vector3d centre = x.rowwise().mean();
  for (Eigen::Index i = 0; i < x.cols(); ++i) x.col(i) = 2.0 * centre - x.col(i);
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
  const Direction d = random.direction();
  Points x = rest;
  switch (kind) {
    case Deformation::Squash:
      squash(x, d, kSquashed);
      break;
    case Deformation::Twist:
      twist(x, d);
      break;
    case Deformation::Noise:
      moveAll(x, kNoise * size, random);
      break;
    case Deformation::Push:
      push(x, random.below(static_cast<std::size_t>(x.cols())), d, size);
      break;
    case Deformation::Mirror:
      mirrorSlab(x, d);
      break;
    case Deformation::Flatten:
      squash(x, d, 0.0);
      break;
    case Deformation::Inversion:
      invert(x);
      break;
  }
  moveAll(x, kUnevenness * size, random);
  return x;
}

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

constexpr double kResidual = 1e-5;  // of the eigenvalue, whose own error is the square of that

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
constexpr double kLightest = 1e-6, kFirst = 1e-3, kHeaviest = 20.0;
constexpr double kStride = 1.6;  // beyond what is too much a body can come back by luck
constexpr double kPrecision = 1.04;

// The motion, in units of the size, the mean mass of a point and the stiffness.
constexpr double kMaxDrag = 0.1;  // at most, and sqrt(load): more would hold up what topples
constexpr double kFriction = 0.5;
constexpr double kSafeStepShare = 0.5;   // of the safe step
constexpr double kSettlingTime = 300.0;  // at most: drag takes 13 powers of ten of the energy
constexpr double kFallTimes = 20.0;      // or 1/sqrt(load) so often: unevenness grows by e in 1.6 of them
constexpr double kCalmSpeed = 1e-3;      // root mean square over the load: at rest, when it lasts
constexpr int kCalmSteps = 20;
constexpr double kUnevenStart = 1e-3;  // of the start: no body stands in an unstable equilibrium

// Common bodies take some hundred thousand steps for all loads together.
constexpr std::size_t kMaxStandingSteps = 4'000'000;
constexpr std::size_t kStepsBetweenQuestions = 256;

// What counts as standing.
constexpr double kMinHeight = 0.5;     // over the height at rest
constexpr double kMaxDistance = 0.05;  // of the rest shape afterwards: dents are no collapse

/// The body in units of 1, its lowest point on the floor y = 0.
struct StandingBody {
  RelaxedBody shape;
  PointState state;
  BodyTerms terms;
  Points rest;
  double step = 0.0;
  std::function<bool()> goOn;
  std::size_t steps = 0;  ///< so far
  bool givenUp = false;   ///< for want of steps, or because it was asked to end
};

SoftBodySettings unitSettings(SoftBodySettings settings, double size, std::size_t points) {
  const double stiffness = settings.extensionStiffness;
  settings.scale.setConstant(1.0 / size);
  settings.totalMass = static_cast<double>(points);
  settings.compressionStiffness /= stiffness;
  settings.extensionStiffness = 1.0;
  settings.damping = settings.pressure = 0.0;
  if (settings.volumeModulus > 0.0) settings.volumeModulus *= size / stiffness;
  return settings;
}

StandingBody makeStanding(const SpringNetwork& network, const SoftBodySettings& settings) {
  StandingBody body{RelaxedBody(network), restState(network, settings), {network, settings}, {}, 0.0, {}};
  body.state.position.row(1).array() -= body.state.position.row(1).minCoeff();
  body.rest = body.state.position;
  body.step = kSafeStepShare * 2.0 / std::sqrt(boundSquared(body.terms, body.state));
  body.givenUp = !(kSettlingTime / body.step <= static_cast<double>(kMaxStandingSteps));
  return body;
}

/// Counts a step; whether it may be made.
bool mayStep(StandingBody& body) {
  const bool asks = body.goOn && body.steps % kStepsBetweenQuestions == 0;
  body.givenUp = body.givenUp || ++body.steps > kMaxStandingSteps || (asks && !body.goOn());
  return !body.givenUp;
}

/// A point that would pass the floor loses its speed into it, and along it what friction takes (Coulomb).
void touchFloor(PointState& state, double dt) {
  for (Eigen::Index i = 0; i < state.position.cols(); ++i) {
    auto v = state.velocity.col(i);
    const double stop = -state.position(1, i) / dt - v.y();
    if (stop <= 0.0) continue;
    const double along = std::hypot(v.x(), v.z());
    const double kept = along > 0.0 ? std::max(0.0, 1.0 - kFriction * stop / along) : 0.0;
    v.x() *= kept;
    v.z() *= kept;
    v.y() += stop;
  }
}

/// Lets the body move until it rests.
void settle(StandingBody& body, double gravity, double mostTime, double calmSpeed) {
  SolverBody stepped = solverBody(body.terms, body.state);
  prepareVolumes(stepped, body.step);
  PointState& p = body.state;
  p.velocity.setZero();
  const double drag = gravity > 0.0 ? std::min(kMaxDrag, std::sqrt(gravity)) : kMaxDrag;
  const double dt = body.step, kept = std::exp(-drag * dt);
  const double calm = calmSpeed * calmSpeed * static_cast<double>(p.position.cols());
  int calmSteps = 0;
  for (double time = 0.0; time < mostTime && calmSteps < kCalmSteps && mayStep(body); time += dt) {
    computeElasticForces(stepped);
    p.velocity = kept * (p.velocity + dt * p.force.cwiseProduct(p.inverseMass));
    p.velocity.row(1).array() -= dt * gravity;
    if (gravity > 0.0) touchFloor(p, dt);
    p.position += dt * p.velocity;
    calmSteps = p.velocity.squaredNorm() < calm ? calmSteps + 1 : 0;
  }
}

double heightOf(const Points& position) { return position.row(1).maxCoeff() - position.row(1).minCoeff(); }

/// The height divided by that of the rest shape, turned as the body is now: a body that has toppled and kept
/// its shape has not collapsed.
double relativeHeight(const StandingBody& body) {
  const Eigen::Matrix4d attitude = Eigen::umeyama(body.rest, body.state.position, false);
  return heightOf(body.state.position) / heightOf(attitude.topLeftCorner<3, 3>() * body.rest);
}

bool carries(StandingBody& body, double load) {
  Random random(1);
  Points& position = body.state.position;
  position = body.rest;
  for (double& x : position.reshaped()) x += kUnevenStart * (random.uniform() - 0.5);
  position.row(1).array() -= position.row(1).minCoeff();
  const double mostTime = std::max(kSettlingTime, kFallTimes / std::sqrt(load));
  settle(body, load, mostTime, kCalmSpeed * load);
  if (body.givenUp || !(relativeHeight(body) >= kMinHeight)) return false;
  settle(body, 0.0, kSettlingTime, kCalmSpeed * load);
  return !body.givenUp && distanceToRest(body.shape, position) < kMaxDistance;
}

/// The largest load before the first that is too much; 0 if all are. Without meaning once given up.
double loadLimit(StandingBody& body) {
  double carried = kFirst;
  while (!carries(body, carried) && !body.givenUp)
    if ((carried *= 0.5) < kLightest) return 0.0;
  double tooMuch = kStride * carried;
  while (tooMuch < kHeaviest && carries(body, tooMuch)) {
    carried = tooMuch;
    tooMuch *= kStride;
  }
  while (tooMuch > kPrecision * carried && !body.givenUp) {
    const double load = std::sqrt(carried * tooMuch);
    (carries(body, load) ? carried : tooMuch) = load;
  }
  return carried;
}

/// For a body of one piece, with its scale applied.
std::optional<double> leastStiffnessOfPiece(const SpringNetwork& network, const SoftBodySettings& settings,
                                            double gravity, const std::function<bool()>& goOn) {
  const std::size_t points = network.restPoints.size();
  const double size = extent(network.restPoints);
  if (network.springs.empty() || !(size > 0.0)) return 0.0;
  StandingBody body = makeStanding(network, unitSettings(settings, size, points));
  body.goOn = goOn;
  const double load = body.givenUp ? 0.0 : loadLimit(body);
  if (body.givenUp) return std::nullopt;
  const double meanMass = settings.totalMass / static_cast<double>(points);
  return load > 0.0 ? meanMass * gravity / (load * size) : HUGE_VAL;
}

/// Of the body as a whole: its pieces are of one material.
double volumeModulusOf(const SpringNetwork& network, const SoftBodySettings& settings) {
  const BodyTerms terms(network, settings);
  return std::max(0.0, terms.tetrahedra.empty() ? terms.volumes->modulus : terms.tetrahedra->modulus);
}

double massOfPoints(const SpringNetwork& network, const std::vector<Eigen::Index>& points) {
  double mass = 0.0;
  for (const Eigen::Index i : points) mass += network.massFractions[static_cast<std::size_t>(i)];
  return mass;
}

/// The most that a piece needs.
std::optional<double> leastStiffnessOfPieces(const SpringNetwork& network, SoftBodySettings settings,
                                             double gravity, const Progress& progress) {
  double done = 0.0, most = 0.0;
  settings.volumeModulus = volumeModulusOf(network, settings);
  for (const std::vector<Eigen::Index>& points : findPieces(network)) {
    SoftBodySettings own = settings;
    own.totalMass *= massOfPoints(network, points);
    const auto goOn = [&] { return !progress || progress("own weight", done); };
    const std::optional<double> one = leastStiffnessOfPiece(pieceOf(network, points), own, gravity, goOn);
    if (!one) return std::nullopt;
    most = std::max(most, *one);
    done += static_cast<double>(points.size()) / static_cast<double>(network.restPoints.size());
  }
  return most;
}

}  // namespace

std::optional<double> leastStiffness(const SpringNetwork& network, const SoftBodySettings& settings,
                                     double gravity, const Progress& progress) {
  if (network.springs.empty() || !(gravity > 0.0)) return 0.0;
  if (!(settings.extensionStiffness > 0.0)) return HUGE_VAL;
  SpringNetwork scaled = network;
  for (Eigen::Vector3d& p : scaled.restPoints) p = p.cwiseProduct(settings.scale);
  SoftBodySettings unscaled = settings;
  unscaled.scale.setOnes();
  return leastStiffnessOfPieces(scaled, unscaled, gravity, progress);
}

}  // namespace limber
