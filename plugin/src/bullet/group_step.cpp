// SPDX-License-Identifier: Zlib

// This file chooses how each group is stepped, steps those that are in no island, bodies of one network side
// by side, and takes out energy that a step has made.

#include "bullet/linked_group.h"
#include "bullet/point_contacts.h"
#include "solver/point_state.h"
#include "solver/springs.h"
#include "solver/stepping_choice.h"
#include "solver/volumes.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {
namespace {

/// The strictest of the bodies' choices; springs between rigid bodies alone have the defaults. Linked bodies
/// are stepped by Verlet whatever they choose.
Stepping strictest(const LinkedGroup& group) {
  if (group.bodies.empty()) return Stepping();
  Stepping all = group.bodies[0]->settings.stepping;
  for (const SoftBodyData* body : group.bodies) {
    const Stepping& s = body->settings.stepping;
    all.minSubsteps = std::max(all.minSubsteps, s.minSubsteps);
    all.periodTolerance = std::min(all.periodTolerance, s.periodTolerance);
    for (auto part : {&Stepping::tolerance, &Stepping::relativeTolerance})
      if (s.*part > 0.0) all.*part = all.*part > 0.0 ? std::min(all.*part, s.*part) : s.*part;
    if (s.maxSubsteps > 0)
      all.maxSubsteps = all.maxSubsteps > 0 ? std::min(all.maxSubsteps, s.maxSubsteps) : s.maxSubsteps;
  }
  return all;
}

/// The largest ratio of an inverse mass to that of the settings. The eigenvalues of M^-1/2 K M^-1/2 grow by
/// that at most.
double lightest(const SoftBodyData& body) {
  double most = 0.0;
  for (std::size_t i = 0; i < body.network->massFractions.size(); ++i)
    most = std::max(most, body.state.inverseMass.col(static_cast<Eigen::Index>(i)).maxCoeff() *
                              body.network->massFractions[i]);
  return most * body.settings.totalMass;
}

void updateBounds(SoftBodyData& body) {
  const Points& w = body.state.inverseMass;
  body.frequencySquared = limber::frequencyBoundSquared(body.springs, w, body.stiffnessSums);
  body.fastestSquared = body.model->fastestAtRest * lightest(body);
  body.dampingRate = dampingRateBound(body.springs, w);
  body.volumes.kept.value = 0.0;
  body.rateHistory = RateHistory();
  body.frequencyStale = false;
}

/// rad per tick, which the usual number of substeps resolves anyhow.
constexpr double kNegligibleTurn = 0.5;

MotionRates ratesOf(SoftBodyData& body, double tick) {
  if (body.frequencyStale) updateBounds(body);
  MotionRates rates;
  rates.boundSquared = body.frequencySquared + keptVolumeBoundSquared(body.volumes, body.state, tick) +
                       tetrahedronFrequencyBoundSquared(body.tetrahedra, body.state, tick);
  const bool nearRest = !body.volumes.farFromRest && !body.tetrahedra.farFromRest;
  rates.fastestSquared = nearRest ? std::min(rates.boundSquared, body.fastestSquared) : rates.boundSquared;
  rates.turnRate = fastestTurn(body.springs, body.state, kNegligibleTurn / tick);
  return rates;
}

MotionRates larger(const MotionRates& a, const MotionRates& b) {
  return {std::max(a.boundSquared, b.boundSquared), std::max(a.fastestSquared, b.fastestSquared),
          std::max(a.turnRate, b.turnRate)};
}

/// s, for which a body without dampers keeps the fastest rates it has had.
constexpr double kRateMemory = 0.25;

/// What Verlet keeps for ever is not the energy but something that differs from it by some (omega dt)^2: each
/// change of the substep makes or takes as much. In an undamped body that oscillates, such changes come at
/// the same moments of each oscillation and add up, so its substeps follow the largest rates of a while.
MotionRates largestRecentRates(SoftBodyData& body, const MotionRates& rates, double tick) {
  if (body.springs->damped) return rates;
  RateHistory& kept = body.rateHistory;
  kept.age += tick;
  if (kept.age > kRateMemory) kept = {MotionRates(), kept.now, 0.0};
  kept.now = larger(kept.now, rates);
  return larger(kept.now, kept.before);
}

/// Own springs and links add up to a stiffness matrix K = K_own + K_links, whose largest eigenvalue is at
/// most the sum of theirs.
MotionRates ratesOf(LinkedGroup& group, double tick) {
  MotionRates rates;
  for (SoftBodyData* body : group.bodies)
    rates = larger(rates, largestRecentRates(*body, ratesOf(*body, tick), tick));
  const double links = linkFrequencyBoundSquared(group.step.links);
  rates.boundSquared += links;
  rates.fastestSquared += links;
  return rates;
}

SteppingProblem problemOf(LinkedGroup& group, double tick) {
  SteppingProblem p;
  const MotionRates rates = ratesOf(group, tick);
  p.frequencies = {rates.boundSquared, rates.fastestSquared};
  p.turnRate = rates.turnRate;
  p.tick = tick;
  for (SoftBodyData* body : group.bodies) {
    p.dampingRate = std::max(p.dampingRate, body->dampingRate);
    p.errorCoefficient = std::max(p.errorCoefficient, body->errorCoefficient);
    p.size = p.size > 0.0 ? std::min(p.size, body->size) : body->size;
    p.touching = p.touching || !body->contacts.empty();
    p.narrow = body->model->narrow;
    p.cheapNewton = body->model->cheapNewton;
  }
  p.implicitPossible = isPlain(group.step) && canStepImplicitly(group.step.bodies[0]);
  p.held = p.implicitPossible && (group.step.bodies[0].points->inverseMass.array() == 0.0).any();
  return p;
}

/// Whether the group's bodies ask for an error tolerance, so that a tick may have to be stepped again.
bool hasTolerance(const LinkedGroup& group) {
  const Stepping& s = group.stepping;
  return s.tolerance > 0.0 || s.relativeTolerance > 0.0;
}

void setChoice(LinkedGroup& group, const SteppingChoice& choice) {
  group.stepper = choice.stepper;
  group.substeps = choice.substeps;
  group.cut = choice.cut;
}

/// Puts the points back to where the tick started from.
void rewind(LinkedGroup& group) {
  for (SoftBodyData* body : group.bodies) {
    body->state.position = body->masses.startPosition;
    body->state.velocity = body->startVelocity;
    if (body->implicit) body->implicit->meanOver = 0.0;
    for (PlaneContact& row : body->contacts) row.impulse = TickImpulse();
    for (PlaneContact& row : body->watch->rows) row.impulse = TickImpulse();
  }
}

void stepOnce(LinkedGroup& group, double tick, SharedFactors& factors) {
  if (group.stepper == Stepper::Verlet) return stepVerlet(group.step, tick, group.substeps);
  const auto kind =
      group.stepper == Stepper::BandedNewton ? MidpointSolver::Kind::Newton : MidpointSolver::Kind::Shared;
  std::unique_ptr<ImplicitState>& implicit = group.bodies[0]->implicit;
  if (!implicit) implicit = std::make_unique<ImplicitState>();
  stepImplicit(group.step.bodies[0], *implicit, kind, tick, group.substeps, factors);
}

/// The largest of the bodies' errors over the square of the substep, m/s^3.
double errorCoefficient(const LinkedGroup& group, double tick) {
  double largest = 0.0;
  for (const SolverBody& body : group.step.bodies) largest = std::max(largest, body.errorRate);
  return largest / std::pow(tick / group.substeps, 2);
}

/// Times a tick is done again because its error was larger than foreseen.
constexpr int kMaxRetries = 3;

// --- energy ------------------------------------------------------------------------------------------------

double energyOf(SolverBody& body) {
  return kineticEnergy(*body.points) + elasticEnergy(body, body.points->position);
}

/// Whether Verlet's substep does not resolve the push against the change of volume where the body is now.
bool isForceScaled(LinkedGroup& group, double tick) {
  if (group.stepper != Stepper::Verlet) return false;
  SoftBodyData& body = *group.bodies[0];
  const double dt = tick / group.substeps;
  return isHeldBack(body.volumes, body.state, dt) || isHeldBack(body.tetrahedra, body.state, dt);
}

bool bounces(const std::vector<PlaneContact>& rows) {
  return std::any_of(rows.begin(), rows.end(), [](const PlaneContact& row) { return row.restitution > 0.0; });
}

/// Whether it is one body and what holds its points, if anything, stands still and so does no work.
bool isFreeBody(const LinkedGroup& group) {
  if (group.bodies.size() != 1) return false;
  const PointState& s = group.bodies[0]->state;
  return (s.inverseMass.array() > 0.0 || s.velocity.array() == 0.0).all();
}

bool isFolded(const SoftBodyData& body) { return body.volumes.farFromRest || body.tetrahedra.farFromRest; }

/// `lasting`: the bound is that of the first of these ticks, changes from outside apart; `once`: of this one.
void guard(LinkedGroup& group, bool lasting, bool once) {
  const bool lasted = group.energyLimited && group.limitPersists;
  group.limitPersists = lasting;
  group.energyLimited = lasting || once;
  if (!group.energyLimited) return;
  const double energy = energyOf(group.step.bodies[0]);
  group.energyBound = lasting && lasted ? group.energyBound + energy - group.energyAtEnd : energy;
}

/// Bodies that are torn apart or turned inside out, in free motion: substeps that do not resolve the push
/// against the change of volume hold it back, which may give energy. Where they resolve it there is nothing
/// to guard: energy that swings with the motion would be cut at each swing. Bodies that bounce: no bounce is
/// exact where substeps only just resolve the oscillations between bounces. Bodies whose budget is cut:
/// springs that turn round within a substep, as crushed ones do, give or take energy at random. The bound of
/// both is the energy with which that began, for the same reason.
void startEnergyLimit(LinkedGroup& group, double tick) {
  if (group.inIsland) return;  // see limitIslandEnergy()
  const bool free = isFreeBody(group) && isPlain(group.step);
  const bool cut = group.cut && group.stepper == Stepper::Verlet;
  const bool lasting =
      free && areSurfacesAtRest(group.bodies[0]->contacts) && (cut || bounces(group.bodies[0]->contacts));
  guard(group, lasting, free && group.bodies[0]->contacts.empty() && isFolded(*group.bodies[0]));
  if (group.energyLimited && !lasting) group.forceScaled = isForceScaled(group, tick);
}

/// Takes so many J out of all motion; returns what was not there.
double slowDown(PointState& points, double energy) {
  const double there = kineticEnergy(points), taken = std::min(energy, there);
  if (taken > 0.0) points.velocity *= std::sqrt(1.0 - taken / there);
  return energy - taken;
}

/// Takes what the energy has risen by, less the work of the constant accelerations, out of the motion.
void endEnergyLimit(LinkedGroup& group, double tick) {
  if (!group.energyLimited || !(group.limitPersists || group.forceScaled || isForceScaled(group, tick)))
    return;
  const SoftBodyData& body = *group.bodies[0];
  double& allowed = group.energyBound;
  for (Eigen::Index i = 0; i < body.state.position.cols(); ++i)
    allowed +=
        massOf(body.state.inverseMass, i) *
        body.state.acceleration.col(i).dot(body.state.position.col(i) - body.masses.startPosition.col(i));
  SolverBody& stepped = group.step.bodies[0];
  group.energyAtEnd = energyOf(stepped);
  const double excess = group.energyAtEnd - allowed;
  if (!(excess > 0.0)) return;
  double left = removeKineticEnergy(*stepped.points, excess);
  // what is left went into the motion as a whole, which only what it bounces off can have given
  if (!group.bodies[0]->contacts.empty()) left = slowDown(*stepped.points, left);
  group.energyAtEnd -= excess - left;
}

// --- one group ---------------------------------------------------------------------------------------------

/// Steps the group; with a tolerance again, more finely, where the error turns out larger than foreseen.
void stepLinkedGroup(LinkedGroup& group, double tick, SharedFactors& factors) {
  stepOnce(group, tick, factors);
  if (!hasTolerance(group) || !group.step.links.rigids.empty()) return;
  SteppingProblem problem = problemOf(group, tick);
  for (int i = 0; i < kMaxRetries; ++i) {
    problem.errorCoefficient = std::max(problem.errorCoefficient, errorCoefficient(group, tick));
    const SteppingChoice choice = limber::chooseStepping(problem, group.stepping);
    if (choice.substeps <= group.substeps) return;
    setChoice(group, choice);
    rewind(group);
    stepOnce(group, tick, factors);
  }
}

/// After the step of a group that is in no island: steps it again with watches on (point_contacts.h) where
/// a point got farther than contacts were looked for, and something is there.
void repeatIfMissed(LinkedGroup& group, double tick, SharedFactors& factors) {
  bool missed = false;
  for (SoftBodyData* body : group.bodies) missed = mayHaveMissedContacts(*body) || missed;
  if (!missed) return;
  rewind(group);
  stepLinkedGroup(group, tick, factors);
}

}  // namespace

bool areSurfacesAtRest(const std::vector<PlaneContact>& rows) {
  const auto isStill = [](const PlaneContact& row) { return row.surfaceVelocity.isZero(0.0); };
  return std::all_of(rows.begin(), rows.end(), isStill);
}

void chooseStepping(LinkedGroup& group, double tick) {
  group.stepping = strictest(group);
  SteppingProblem problem = problemOf(group, tick);
  setChoice(group, limber::chooseStepping(problem, group.stepping));
  for (SoftBodyData* body : group.bodies) body->prefersImplicit = group.stepper != Stepper::Verlet;
  if (group.inIsland && group.stepper != Stepper::Verlet) {
    problem.implicitPossible = false;
    setChoice(group, limber::chooseStepping(problem, group.stepping));
  }
  startEnergyLimit(group, tick);
  // what else moves the body may throw it farther than was foreseen for it alone
  const bool together = group.inIsland || !isPlain(group.step);
  for (SoftBodyData* body : group.bodies) {
    body->startVelocity = body->state.velocity;
    body->watch->on = body->settings.continuousCollision && (body->watch->on || together);
  }
}

void limitIslandEnergy(LinkedGroup& group, bool alone) {
  guard(group, alone && group.stepping.maxSubsteps > 0 && isFreeBody(group), false);
}

// --- groups side by side -----------------------------------------------------------------------------------

namespace {

/// A block of more springs than this would not stay in the cache next to the processor (about 0.5 kB a spring
/// with eight lanes); such bodies are stepped one by one.
constexpr std::size_t kMaxSpringsInLanes = 1000;

bool canUseLanes(const LinkedGroup& group) {
  return !hasTolerance(group) && group.stepper == Stepper::Verlet && isPlain(group.step) &&
         group.bodies[0]->springs.size() <= kMaxSpringsInLanes && group.bodies[0]->springs.size() > 0;
}

/// Bodies side by side go through the same triangles and tetrahedra.
int volumeKind(const SoftBodyData& body) {
  if (body.volumes.empty() && body.tetrahedra.empty()) return 0;
  return body.settings.scale.prod() < 0.0 ? -1 : 1;
}

}  // namespace

bool StepPlan::Candidate::fitsWith(const Candidate& other) const {
  return std::tie(network, substeps, damped, volumes) ==
         std::tie(other.network, other.substeps, other.damped, other.volumes);
}

bool StepPlan::Candidate::operator<(const Candidate& other) const {
  return std::tie(network, substeps, damped, volumes, group) <
         std::tie(other.network, other.substeps, other.damped, other.volumes, other.group);
}

void StepPlan::clear() {
  blocks_.clear();
  networkOf_.clear();
}

void StepPlan::number(const std::vector<LinkedGroup>& groups) {
  std::map<const SpringNetwork*, std::size_t> numbers;
  for (const LinkedGroup& group : groups) {
    const SpringNetwork* network = group.bodies.empty() ? nullptr : group.bodies[0]->network.get();
    networkOf_.push_back(numbers.try_emplace(network, numbers.size()).first->second);
  }
}

void StepPlan::stepOrCollect(std::vector<LinkedGroup>& groups, double tick) {
  candidates_.clear();
  for (std::size_t i = 0; i < groups.size(); ++i) {
    if (groups[i].asleep || groups[i].inIsland) continue;
    if (canUseLanes(groups[i]))
      candidates_.push_back({networkOf_[i], groups[i].substeps, groups[i].bodies[0]->springs->damped,
                             volumeKind(*groups[i].bodies[0]), i});
    else
      stepLinkedGroup(groups[i], tick, factors_);
  }
  std::sort(candidates_.begin(), candidates_.end());
}

void StepPlan::stepBlock(std::vector<LinkedGroup>& groups, std::size_t begin, std::size_t end, double tick) {
  if (blocksUsed_ == blocks_.size()) blocks_.emplace_back();
  LaneBlock& block = blocks_[blocksUsed_++];
  block.lanes.resize(end - begin);
  for (std::size_t i = begin; i < end; ++i) {
    const SolverBody& body = groups[candidates_[i].group].step.bodies[0];
    LaneBlock::Lane& lane = block.lanes[i - begin];
    if (lane.body.points != body.points) lane.revision = 0;
    lane.body = body;
  }
  stepLanes(block, scratch_, tick, candidates_[begin].substeps, set_);
  for (std::size_t i = begin; i < end; ++i)
    groups[candidates_[i].group].step.bodies[0].errorRate = block.lanes[i - begin].body.errorRate;
}

/// Bodies that are alone in their block have nothing to gain from it.
void StepPlan::stepRun(std::vector<LinkedGroup>& groups, std::size_t begin, std::size_t end, double tick) {
  const auto lanes = static_cast<std::size_t>(laneCount(set_));
  for (std::size_t i = begin; i < end; i += lanes) {
    const std::size_t stop = std::min(i + lanes, end);
    if (stop - i > 1)
      stepBlock(groups, i, stop, tick);
    else
      stepLinkedGroup(groups[candidates_[i].group], tick, factors_);
  }
}

void StepPlan::step(std::vector<LinkedGroup>& groups, double tick) {
  if (networkOf_.size() != groups.size()) number(groups);
  stepOrCollect(groups, tick);
  blocksUsed_ = 0;
  for (std::size_t begin = 0, end; begin < candidates_.size(); begin = end) {
    end = begin + 1;
    while (end < candidates_.size() && candidates_[end].fitsWith(candidates_[begin])) ++end;
    stepRun(groups, begin, end, tick);
  }
  for (LinkedGroup& group : groups)
    if (!group.asleep && !group.inIsland) repeatIfMissed(group, tick, factors_);
}

// --- after the step ----------------------------------------------------------------------------------------

namespace {

/// s, for which a peak of the error is remembered.
constexpr double kErrorMemory = 0.25;

}  // namespace

void reportStepping(LinkedGroup& group, double tick) {
  for (SoftBodyData* body : group.bodies) body->watch->merge();
  endEnergyLimit(group, tick);
  for (std::size_t i = 0; i < group.bodies.size(); ++i) {
    SoftBodyData& body = *group.bodies[i];
    const double square = std::pow(tick / group.substeps, 2);
    const double faded = body.errorCoefficient * std::max(0.0, 1.0 - tick / kErrorMemory);
    body.errorCoefficient = std::max(group.step.bodies[i].errorRate / square, faded);
    body.errorPerSecond = body.errorCoefficient * square;
    body.substeps = group.substeps;
    body.stepper = group.stepper;
    if (group.stepper == Stepper::Verlet && body.implicit) body.implicit->meanOver = 0.0;
  }
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
