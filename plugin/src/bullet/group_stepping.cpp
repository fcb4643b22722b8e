// SPDX-License-Identifier: Zlib
#include "bullet/group_stepping.h"

#include "core/body_measures.h"
#include "core/energy_guard.h"
#include "core/kept_volume_bound.h"
#include "core/spring_forces.h"
#include "core/stepping_choice.h"

#include <algorithm>
#include <cmath>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {
namespace {

/// The strictest of the bodies' choices; springs between rigid bodies alone have the defaults. Linked bodies
/// are stepped by Verlet whatever they choose.
Stepping strictest(const TickGroup& group) {
  if (group.bodies.empty()) return Stepping();
  Stepping all = group.bodies[0]->settings.stepping;
  for (const SoftBodyData* body : group.bodies) {
    const Stepping& s = body->settings.stepping;
    all.atLeast = std::max(all.atLeast, s.atLeast);
    all.periodTolerance = std::min(all.periodTolerance, s.periodTolerance);
    for (auto part : {&Stepping::tolerance, &Stepping::relativeTolerance})
      if (s.*part > 0.0) all.*part = all.*part > 0.0 ? std::min(all.*part, s.*part) : s.*part;
    if (s.budget > 0) all.budget = all.budget > 0 ? std::min(all.budget, s.budget) : s.budget;
  }
  return all;
}

/// The largest ratio of an inverse mass to that of the settings. The eigenvalues of M^-1/2 K M^-1/2 grow by
/// that at most.
double lightest(const SoftBodyData& body) {
  double most = 0.0;
  for (std::size_t i = 0; i < body.network->massShares.size(); ++i)
    most = std::max(most, body.state.inverseMass.col(static_cast<Eigen::Index>(i)).maxCoeff() *
                              body.network->massShares[i]);
  return most * body.settings.totalMass;
}

void updateBounds(SoftBodyData& body) {
  const Points& w = body.state.inverseMass;
  body.frequencySquared = limber::frequencyBoundSquared(body.springs, w, body.stiffnessSums);
  body.fastestSquared = body.fastestAtRest * lightest(body);
  body.dampingRate = dampingRateBound(body.springs, w);
  body.volumes.kept.value = 0.0;
  body.frequencyStale = false;
}

/// Own springs and links add up to a stiffness matrix K = K_own + K_links, whose largest eigenvalue is at
/// most the sum of theirs.
Frequencies frequenciesOf(TickGroup& group, double tick) {
  Frequencies own;
  for (SoftBodyData* body : group.bodies) {
    if (body->frequencyStale) updateBounds(*body);
    const double bound = body->frequencySquared + keptVolumeBoundSquared(body->volumes, body->state, tick) +
                         tetrahedronFrequencyBoundSquared(body->tetrahedra, body->state);
    own.boundSquared = std::max(own.boundSquared, bound);
    const bool nearRest = !body->volumes.restless && !body->tetrahedra.restless;
    own.fastestSquared =
        std::max(own.fastestSquared, nearRest ? std::min(bound, body->fastestSquared) : bound);
  }
  const double links = linkFrequencyBoundSquared(group.step.links);
  return {own.boundSquared + links, own.fastestSquared + links};
}

/// rad per tick, which the usual number of substeps resolves anyhow.
constexpr double kNegligibleTurn = 0.5;

SteppingProblem problemOf(TickGroup& group, double tick) {
  SteppingProblem p;
  p.frequencies = frequenciesOf(group, tick);
  p.tick = tick;
  for (SoftBodyData* body : group.bodies) {
    p.dampingRate = std::max(p.dampingRate, body->dampingRate);
    p.turnRate = std::max(p.turnRate, fastestTurn(body->springs, body->state, kNegligibleTurn / tick));
    p.errorPerSquare = std::max(p.errorPerSquare, body->errorPerSquare);
    p.size = p.size > 0.0 ? std::min(p.size, body->size) : body->size;
    p.touching = p.touching || !body->contacts.empty();
    p.narrow = body->narrow;
    p.cheapNewton = body->cheapNewton;
  }
  p.implicitPossible = !group.clustered && isPlain(group.step) && canStepImplicitly(group.step.bodies[0]);
  return p;
}

}  // namespace

bool hasTolerance(const TickGroup& group) {
  const Stepping& s = group.stepping;
  return s.tolerance > 0.0 || s.relativeTolerance > 0.0;
}

namespace {

void setChoice(TickGroup& group, const SteppingChoice& choice) {
  group.stepper = choice.stepper;
  group.substeps = choice.substeps;
}

/// Puts the points back to where the tick started from.
void rewind(TickGroup& group) {
  for (SoftBodyData* body : group.bodies) {
    body->state.position = body->masses.startPosition;
    body->state.velocity = body->startVelocity;
    for (ContactRow& row : body->contacts) row.impulse.setZero();
  }
}

void stepOnce(TickGroup& group, double tick, SharedFactors& factors) {
  if (group.stepper == Stepper::Verlet) return stepVerlet(group.step, tick, group.substeps);
  const auto kind =
      group.stepper == Stepper::BandedNewton ? MidpointSolver::Kind::Newton : MidpointSolver::Kind::Shared;
  stepImplicit(group.step.bodies[0], group.bodies[0]->implicit, kind, tick, group.substeps, factors);
}

/// The largest of the bodies' errors over the square of the substep, m/s^3.
double errorPerSquare(const TickGroup& group, double tick) {
  double largest = 0.0;
  for (const SteppedBody& body : group.step.bodies) largest = std::max(largest, body.errorRate);
  return largest / std::pow(tick / group.substeps, 2);
}

/// Times a tick is done again because its error was larger than foreseen.
constexpr int kMostRetries = 3;

}  // namespace

namespace {

double energyOf(SteppedBody& body) {
  return kineticEnergy(*body.points) + elasticEnergy(body, body.points->position);
}

/// Bodies that are torn apart or turned inside out, in free motion: substeps that do not resolve the push
/// against the change of volume hold it back, which may give energy.
void startGuard(TickGroup& group) {
  SoftBodyData* body = group.bodies.size() == 1 ? group.bodies[0] : nullptr;
  group.guarded = body && !group.clustered && (body->volumes.restless || body->tetrahedra.restless) &&
                  isPlain(group.step) && body->contacts.empty() &&
                  (body->state.inverseMass.array() > 0.0).all();
  if (group.guarded) group.energyBefore = energyOf(group.step.bodies[0]);
}

/// Takes what the energy has risen by, less the work of the constant accelerations, out of the motion.
void endGuard(TickGroup& group) {
  if (!group.guarded) return;
  const SoftBodyData& body = *group.bodies[0];
  double allowed = group.energyBefore;
  for (Eigen::Index i = 0; i < body.state.position.cols(); ++i)
    allowed +=
        massOf(body.state.inverseMass, i) *
        body.state.acceleration.col(i).dot(body.state.position.col(i) - body.masses.startPosition.col(i));
  SteppedBody& stepped = group.step.bodies[0];
  const double excess = energyOf(stepped) - allowed;
  if (excess > 0.0) removeKineticEnergy(*stepped.points, excess);
}

}  // namespace

void chooseStepping(TickGroup& group, double tick) {
  group.stepping = strictest(group);
  setChoice(group, limber::chooseStepping(problemOf(group, tick), group.stepping));
  startGuard(group);
  if (!hasTolerance(group)) return;
  for (SoftBodyData* body : group.bodies) body->startVelocity = body->state.velocity;
}

void stepGroup(TickGroup& group, double tick, SharedFactors& factors) {
  stepOnce(group, tick, factors);
  if (!hasTolerance(group) || !group.step.links.rigids.empty()) return;
  SteppingProblem problem = problemOf(group, tick);
  for (int i = 0; i < kMostRetries; ++i) {
    problem.errorPerSquare = std::max(problem.errorPerSquare, errorPerSquare(group, tick));
    const SteppingChoice choice = limber::chooseStepping(problem, group.stepping);
    if (choice.substeps <= group.substeps) return;
    setChoice(group, choice);
    rewind(group);
    stepOnce(group, tick, factors);
  }
}

namespace {

/// s, for which a peak of the error is remembered.
constexpr double kErrorMemory = 0.25;

}  // namespace

void reportStepping(TickGroup& group, double tick) {
  endGuard(group);
  for (std::size_t i = 0; i < group.bodies.size(); ++i) {
    SoftBodyData& body = *group.bodies[i];
    const double square = std::pow(tick / group.substeps, 2);
    const double faded = body.errorPerSquare * std::max(0.0, 1.0 - tick / kErrorMemory);
    body.errorPerSquare = std::max(group.step.bodies[i].errorRate / square, faded);
    body.errorPerSecond = body.errorPerSquare * square;
    body.substeps = group.substeps;
    body.stepper = group.stepper;
  }
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
