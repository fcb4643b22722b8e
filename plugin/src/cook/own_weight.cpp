// SPDX-License-Identifier: Zlib
#include "cook/own_weight.h"

#include "cook/random.h"
#include "cook/relaxation.h"
#include "cook/rest_state.h"
#include "cook/triangle_geometry.h"
#include "core/spring_arrays.h"
#include "core/spring_forces.h"
#include "core/stepping_choice.h"
#include "core/verlet_step.h"
#include "core/volume_term.h"

#include <algorithm>
#include <cmath>

namespace limber {
namespace {

// The search, in loads m g / (k L).
constexpr double kLightest = 1e-6, kFirst = 1e-3, kHeaviest = 20.0;
constexpr double kStride = 1.6;  // beyond what is too much a body can come back by luck
constexpr double kPrecision = 1.04;

// The motion, in units of the size, the mean mass of a point and the stiffness.
constexpr double kDrag = 0.1;  // at most, and sqrt(load): more would hold up what topples
constexpr double kFriction = 0.5;
constexpr double kStepShare = 0.5;       // of the safe step
constexpr double kSettlingTime = 300.0;  // at most: drag takes 13 powers of ten of the energy
constexpr double kFallTimes = 20.0;      // or 1/sqrt(load) so often: unevenness grows by e in 1.6 of them
constexpr double kCalmSpeed = 1e-3;      // root mean square over the load: at rest, when it lasts
constexpr int kCalmSteps = 20;
constexpr double kUnevenness = 1e-3;  // of the start: no body stands in an unstable equilibrium

// What counts as standing.
constexpr double kLeastHeight = 0.5;    // over the height at rest
constexpr double kMostDistance = 0.05;  // of the rest shape afterwards: dents are no collapse

/// The body in units of 1, its lowest point on the floor y = 0.
struct StandingBody {
  RelaxedBody shape;
  PointState state;
  SpringArrays springs;
  VolumeArrays volumes;
  Points rest;
  double step = 0.0;
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
  StandingBody body{RelaxedBody(network), {}, {}, {}, {}, 0.0};
  body.state = restState(network, settings);
  body.state.position.row(1).array() -= body.state.position.row(1).minCoeff();
  body.rest = body.state.position;
  body.springs = makeSprings(network, settings);
  body.volumes = makeVolumes(network, settings);
  std::vector<double> sums;
  double bound = frequencyBoundSquared(body.springs, body.state.inverseMass, sums);
  if (!body.volumes.empty()) bound += volumeFrequencyBoundSquared(body.volumes, body.state, 0.0);
  body.step = body.volumes.timeStep = kStepShare * 2.0 / std::sqrt(bound);
  return body;
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
  SteppedBody stepped{&body.state, &body.springs, nullptr};
  if (!body.volumes.empty()) stepped.volumes = &body.volumes;
  PointState& p = body.state;
  p.velocity.setZero();
  const double drag = gravity > 0.0 ? std::min(kDrag, std::sqrt(gravity)) : kDrag;
  const double dt = body.step, kept = std::exp(-drag * dt);
  const double calm = calmSpeed * calmSpeed * static_cast<double>(p.position.cols());
  int calmSteps = 0;
  for (double time = 0.0; time < mostTime && calmSteps < kCalmSteps; time += dt) {
    computeElasticForces(stepped);
    p.velocity = kept * (p.velocity + dt * p.force.cwiseProduct(p.inverseMass));
    p.velocity.row(1).array() -= dt * gravity;
    if (gravity > 0.0) touchFloor(p, dt);
    p.position += dt * p.velocity;
    calmSteps = p.velocity.squaredNorm() < calm ? calmSteps + 1 : 0;
  }
}

bool carries(StandingBody& body, double load) {
  Random random(1);
  Points& position = body.state.position;
  position = body.rest;
  for (double& x : position.reshaped()) x += kUnevenness * (random.uniform() - 0.5);
  position.row(1).array() -= position.row(1).minCoeff();
  const double mostTime = std::max(kSettlingTime, kFallTimes / std::sqrt(load));
  settle(body, load, mostTime, kCalmSpeed * load);
  const double height = position.row(1).maxCoeff();
  if (!(height >= kLeastHeight * body.rest.row(1).maxCoeff())) return false;
  settle(body, 0.0, kSettlingTime, kCalmSpeed * load);
  return distanceToRest(body.shape, position) < kMostDistance;
}

/// The largest load before the first that is too much; 0 if all are.
double loadLimit(StandingBody& body) {
  double carried = kFirst;
  while (!carries(body, carried))
    if ((carried *= 0.5) < kLightest) return 0.0;
  double tooMuch = kStride * carried;
  while (tooMuch < kHeaviest && carries(body, tooMuch)) {
    carried = tooMuch;
    tooMuch *= kStride;
  }
  while (tooMuch > kPrecision * carried) {
    const double load = std::sqrt(carried * tooMuch);
    (carries(body, load) ? carried : tooMuch) = load;
  }
  return carried;
}

}  // namespace

double leastStiffness(const SpringNetwork& network, const SoftBodySettings& settings, double gravity) {
  if (network.springs.empty() || !(gravity > 0.0)) return 0.0;
  if (!(settings.extensionStiffness > 0.0)) return HUGE_VAL;
  SpringNetwork scaled = network;
  for (Eigen::Vector3d& p : scaled.restPoints) p = p.cwiseProduct(settings.scale);
  const std::size_t points = network.restPoints.size();
  const double size = extent(scaled.restPoints);
  StandingBody body = makeStanding(scaled, unitSettings(settings, size, points));
  const double load = loadLimit(body);
  const double meanMass = settings.totalMass / static_cast<double>(points);
  return load > 0.0 ? meanMass * gravity / (load * size) : HUGE_VAL;
}

}  // namespace limber
