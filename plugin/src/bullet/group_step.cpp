// SPDX-License-Identifier: Zlib

// This file chooses the stepper of a group, steps it if it is in no island, and removes energy that a step
// has added.

#include "bullet/body_in_world.h"
#include "bullet/linked_group.h"
#include "bullet/point_contacts.h"

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {
namespace {

/// Returns the strictest of the bodies' settings. A group without soft bodies has the defaults. Linked bodies
/// are always stepped by Verlet.
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

// --- budgets -----------------------------------------------------------------------------------------------

void setConstants(SoftBodyData& body, const ElasticConstants& constants) {
  body.springs.original = constants.springs;
  body.volumes.constants = constants.volumes;
  body.tetrahedra.constants = constants.tetrahedra;
  if (SpringConstants* own = body.springs.yielded.get())
    for (std::size_t i = 0; i < own->a.size(); ++i) {
      if (own->extensionStiffness[i] == 0.0 && own->compressionStiffness[i] == 0.0) continue;  // broken
      own->extensionStiffness[i] = constants.springs->extensionStiffness[i];
      own->compressionStiffness[i] = constants.springs->compressionStiffness[i];
    }
  ++body.springs.revision;
  body.implicit.reset();
  body.frequencyStale = true;
}

}  // namespace

void softenTo(SoftBodyData& body, double largest, const Points& inverseMass) {
  const BodyModel& model = *body.model;
  const ElasticConstants full{model.springs.original, model.volumes.constants, model.tetrahedra.constants};
  const Points rest = scaledRest(*model.network, body.settings.scale);
  body.softening = largest > 0.0 ? softened(*model.softening, full, rest, inverseMass, largest) : nullptr;
  setConstants(body, body.softening ? body.softening->constants : full);
}

namespace {

/// Makes a softened body stiffer, up to the bound `wanted` (rad^2/s^2), or to its full stiffness with 0.
///
/// Strains that have cost a soft body little energy return much of it to a stiff one: bodies that were linked
/// to one with a budget in every other tick gained a factor of 20 in each. So the stiffness grows by a factor
/// of e in a sixth of a second, in which the body relaxes, unless the energy hardly changes.
void stiffen(SoftBodyData& body, double wanted, double tick) {
  constexpr double kRate = 6.0;        // 1/s
  constexpr double kUnnoticed = 1e-4;  // J/kg: a speed of 14 mm/s
  const double present = body.softening->largest, growth = std::exp(kRate * tick);
  const double before = elasticEnergy(body);
  softenTo(body, wanted, body.state.inverseMass);
  if (elasticEnergy(body) <= growth * before + kUnnoticed * totalMass(body.state)) return;
  const double slowly = growth * present;
  softenTo(body, wanted > 0.0 ? std::min(wanted, slowly) : slowly, body.state.inverseMass);
}

/// Softens the body so that its fastest oscillation is at most `wanted` (rad^2/s^2), or ends this with 0.
/// Does nothing while the masses stay and the present constants are soft enough, and not much too soft.
void soften(SoftBodyData& body, double wanted, double tick) {
  constexpr double kMuchTooSoft = 2.0;
  if (!body.softening) {
    if (wanted > 0.0) softenTo(body, wanted, body.state.inverseMass);
    return;
  }
  const double present = body.softening->largest;
  if (wanted == 0.0 || wanted > kMuchTooSoft * present) return stiffen(body, wanted, tick);
  if (wanted < present || body.frequencyStale)
    softenTo(body, std::min(present, wanted), body.state.inverseMass);
}

/// (omega dt)^2 of what a budget resolves. The energy of an oscillation that Verlet computes varies by the
/// factor  1 / (1 - (omega dt)^2 / 4),  here 2: more would crush bodies. What is left to the limit of 4 is
/// for volume terms, whose forces grow while a body is deformed and are limited to
/// kernel::kLargestPhaseSquared.
constexpr double kBudgetPhaseSquared = 2.0;

// --- rates -------------------------------------------------------------------------------------------------

/// Returns the largest ratio of an inverse mass to that of the settings. The eigenvalues of M^-1/2 K M^-1/2
/// grow at most by this factor.
double lightest(const SoftBodyData& body) {
  double most = 0.0;
  const std::vector<double>& masses = body.model->masses;
  for (std::size_t i = 0; i < masses.size(); ++i)
    most = std::max(most, body.state.inverseMass.col(static_cast<Eigen::Index>(i)).maxCoeff() * masses[i]);
  return most;
}

void updateBounds(SoftBodyData& body) {
  const Points& w = body.state.inverseMass;
  body.frequencySquared = limber::frequencyBoundSquared(body.springs, w, body.stiffnessSums);
  body.fastestSquared = body.model->fastestAtRest * lightest(body);
  body.dampingRate = dampingRateBound(body.springs, w);
  body.anyHeld = (w.array() == 0.0).any();
  body.volumes.kept.value = 0.0;
  body.rateHistory = RateHistory();
  body.frequencyStale = false;
}

MotionRates ratesOf(SoftBodyData& body, double tick) {
  if (body.frequencyStale) updateBounds(body);
  MotionRates rates;
  rates.boundSquared = body.frequencySquared + keptVolumeBoundSquared(body.volumes, body.state, tick) +
                       tetrahedronFrequencyBoundSquared(body.tetrahedra, body.state, tick);
  const bool nearRest = !body.volumes.farFromRest && !body.tetrahedra.farFromRest;
  rates.fastestSquared = nearRest ? std::min(rates.boundSquared, body.fastestSquared) : rates.boundSquared;
  rates.turnRate = fastestTurn(body.springs, body.state, std::sqrt(sumsOf(body).fastest),
                               negligibleTurn(rates.fastestSquared, tick));
  return rates;
}

MotionRates larger(const MotionRates& a, const MotionRates& b) {
  return {std::max(a.boundSquared, b.boundSquared), std::max(a.fastestSquared, b.fastestSquared),
          std::max(a.turnRate, b.turnRate)};
}

/// s, the time for which an undamped body keeps its largest rates.
constexpr double kRateMemory = 0.25;

/// Returns the largest recent rates of an undamped body, or `rates` of a damped one. Verlet does not conserve
/// the energy but a quantity that differs from it by a part of the order (omega dt)^2. Each change of the
/// substep adds or removes such a part. In an undamped oscillating body these changes happen at the same
/// phase of each oscillation and add up. Substeps for the largest recent rates change less often.
MotionRates largestRecentRates(SoftBodyData& body, const MotionRates& rates, double tick) {
  if (body.springs->damped) return rates;
  RateHistory& kept = body.rateHistory;
  kept.age += tick;
  if (kept.age > kRateMemory) kept = {MotionRates(), kept.now, 0.0};
  kept.now = larger(kept.now, rates);
  return larger(kept.now, kept.before);
}

/// Returns bounds of the rates of a group. The bodies' own springs and the links add up to a stiffness matrix
/// K = K_own + K_links, whose largest eigenvalue is at most the sum of theirs.
MotionRates ratesOf(LinkedGroup& group, double tick) {
  MotionRates rates;
  for (SoftBodyData* body : group.bodies)
    rates = larger(rates, largestRecentRates(*body, ratesOf(*body, tick), tick));
  const double links = linkFrequencyBoundSquared(group.step.links);
  rates.boundSquared += links;
  rates.fastestSquared += links;
  return rates;
}

bool isNear(const PlaneContact& row) { return !row.away; }

/// Whether a point may reach a surface in the tick. Rows of surfaces farther away exist where surfaces are
/// followed, but not where they are flat, and must not change the way in which a body is stepped.
bool anyNear(const SoftBodyData& body) {
  return std::any_of(body.contacts.begin(), body.contacts.end(), isNear);
}

/// Returns the largest speed (m/s) at which the body approaches what it touches, or at which its points move
/// relative to each other while it does.
double impactSpeed(SoftBodyData& body) {
  if (!anyNear(body) && !(body.approach > -HUGE_VAL)) return 0.0;
  double approach = body.approach;
  for (const PlaneContact& row : body.contacts)
    if (isNear(row))
      approach = std::max(approach, row.normal.dot(row.surfaceVelocity - body.state.velocity.col(row.point)));
  return std::max(approach, std::sqrt(sumsOf(body).fastest));
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
    p.impactSpeed = std::max(p.impactSpeed, impactSpeed(*body));
    p.size = p.size > 0.0 ? std::min(p.size, body->size) : body->size;
    p.touching = p.touching || anyNear(*body);
    p.narrow = body->model->narrow;
    p.cheapNewton = body->model->cheapNewton;
  }
  p.implicitPossible = isPlain(group.step) && canStepImplicitly(group.step.bodies[0]);
  p.held = p.implicitPossible && group.bodies[0]->anyHeld;
  return p;
}

void setChoice(LinkedGroup& group, const SteppingChoice& choice) {
  group.stepper = choice.stepper;
  group.substeps = choice.substeps;
  group.cut = choice.cut;
  for (SoftBodyData* body : group.bodies) limitSweeps(body->springs, choice.cut);
}

/// Whether the step may change the springs for good.
bool mayYield(const SpringArrays& springs) {
  return springs->limit.yieldStrain > 0.0 || springs->limit.breakStrain > 0.0;
}

/// Stores the springs as they are at the start of the tick.
void keepSprings(LinkedGroup& group) {
  for (SoftBodyData* body : group.bodies) {
    if (!mayYield(body->springs)) continue;
    if (!body->startSprings) body->startSprings = std::make_unique<SpringConstants>();
    *body->startSprings = body->springs.yielded ? *body->springs.yielded : *body->springs.original;
    body->startBroken = body->springs.broken;
  }
}

void restoreSprings(SoftBodyData& body) {
  SpringArrays& springs = body.springs;
  if (!springs.yielded || !mayYield(springs)) return;
  *springs.yielded = *body.startSprings;
  if (std::exchange(springs.broken, body.startBroken) != body.startBroken) springs.preparedFor = 0.0;
}

/// Restores the state of the points, springs and ends of links at the start of the tick.
void rewind(LinkedGroup& group, double tick) {
  for (std::size_t i = 0; i < group.springs.size(); ++i)
    placeEnds(group.step.links.springs[i], *group.springs[i], tick);
  for (SoftBodyData* body : group.bodies) {
    restoreSprings(*body);
    body->state.position = body->masses.startPosition;
    body->state.velocity = body->startVelocity;
    body->sumsValid = false;
    if (ImplicitState* implicit = body->implicit.get()) {
      implicit->meanOver = 0.0;
      implicit->energyFloor = implicit->floorAtStart;
      implicit->energyAtEnd = implicit->energyAtStart;
    }
    for (PlaneContact& row : body->contacts) row.impulse = TickImpulse();
    for (PlaneContact& row : body->watch->rows) row.impulse = TickImpulse();
  }
}

/// Returns false if the implicit stepper did not succeed.
bool stepImplicitly(LinkedGroup& group, double tick, SharedFactors& factors) {
  const auto kind =
      group.stepper == Stepper::Newton ? MidpointSolver::Kind::Newton : MidpointSolver::Kind::Shared;
  std::unique_ptr<ImplicitState>& implicit = group.bodies[0]->implicit;
  if (!implicit) implicit = std::make_unique<ImplicitState>();
  return stepImplicit(group.step.bodies[0], *implicit, kind, tick, group.substeps, factors);
}

/// Bodies that an implicit stepper cannot step are stepped by Verlet, which is stable for all.
void stepOnce(LinkedGroup& group, double tick, SharedFactors& factors) {
  if (group.stepper != Stepper::Verlet) {
    if (stepImplicitly(group, tick, factors)) return;
    group.bodies[0]->implicit.reset();
    rewind(group, tick);
    SteppingProblem problem = problemOf(group, tick);
    problem.implicitPossible = false;
    setChoice(group, limber::chooseStepping(problem, group.stepping));
  }
  useSpringBatches(group);
  stepVerlet(group.step, tick, group.substeps);
}

/// Returns the largest of the bodies' errors divided by the square of the substep, m/s^3.
double errorCoefficient(const LinkedGroup& group, double tick) {
  double largest = 0.0;
  for (const SolverBody& body : group.step.bodies) largest = std::max(largest, body.errorRate);
  return largest / std::pow(tick / group.substeps, 2);
}

/// Maximum number of repetitions of a tick whose error is larger than predicted.
constexpr int kMaxRetries = 3;

// --- energy ------------------------------------------------------------------------------------------------

double energyOf(SolverBody& body) {
  return kineticEnergy(*body.points) + elasticEnergy(body, body.points->position);
}

/// Returns whether Verlet's substep does not resolve the volume force now, which is then scaled down.
bool isForceScaled(LinkedGroup& group, double tick) {
  if (group.stepper != Stepper::Verlet) return false;
  SoftBodyData& body = *group.bodies[0];
  const double dt = tick / group.substeps;
  return isHeldBack(body.volumes, body.state, dt) || isHeldBack(body.tetrahedra, body.state, dt);
}

bool bounces(const std::vector<PlaneContact>& rows) {
  return std::any_of(rows.begin(), rows.end(),
                     [](const PlaneContact& row) { return isNear(row) && row.restitution > 0.0; });
}

/// Returns whether the group is one body whose held points, if any, are at rest: their holders do no work.
bool isFreeBody(const LinkedGroup& group) {
  if (group.bodies.size() != 1) return false;
  const PointState& s = group.bodies[0]->state;
  return (s.inverseMass.array() > 0.0 || s.velocity.array() == 0.0).all();
}

/// Starts or ends the energy limit. `lasting`: the bound is the energy in the first of consecutive ticks with
/// this flag, plus changes from outside. `once`: the bound is the present energy, for this tick only.
void guard(LinkedGroup& group, bool lasting, bool once) {
  for (SoftBodyData* body : group.bodies) {
    EnergyLimit& limit = body->energyLimit;
    const bool lasted = limit.on && limit.persists;
    limit.persists = lasting;
    limit.on = lasting || once;
    if (!limit.on) continue;
    const double energy = energyOf(group.step.bodies[0]);
    limit.bound = lasting && lasted ? limit.bound + energy - limit.atEnd : energy;
  }
}

/// Whether the motion had too little energy at the end of the last tick to end within the bound: the rest is
/// in the springs, and comes back.
bool isAboveBound(const EnergyLimit& limit) {
  constexpr double kRounding = 1e-6;
  return limit.on && limit.persists && limit.atEnd - limit.bound > kRounding * std::abs(limit.bound);
}

/// s, the time for which a change of the tick's length counts.
constexpr double kTickMemory = 0.25;

void followTick(EnergyLimit& limit, double tick) {
  const bool changes = limit.tick > 0.0 && limit.tick != tick;
  limit.unsteady = changes ? kTickMemory : std::max(0.0, limit.unsteady - tick);
  limit.tick = tick;
}

/// Starts the energy limit of a body in four cases. Torn or inverted bodies in free motion: substeps that do
/// not resolve the volume force scale it down, which may add energy. If they resolve it, there is no limit:
/// the energy oscillates with the motion, and a limit would remove energy in each oscillation. Bodies that
/// bounce: a bounce is not exact if substeps hardly resolve the oscillations between bounces. Bodies with too
/// few substeps (maxSubsteps): springs that reverse within a substep, as crushed ones do, add or remove
/// energy at random. Undamped bodies with ticks of changing length: Verlet conserves a quantity near the
/// energy, a different one for each substep. In the last three cases the bound is the energy in the first of
/// these ticks, because the energy oscillates. It holds on until what exceeds it has been removed.
void startEnergyLimit(LinkedGroup& group, double tick) {
  if (group.inIsland) return;  // see limitIslandEnergy()
  if (!isPlain(group.step)) return guard(group, false, false);
  const SoftBodyData& single = *group.bodies[0];
  const bool cut = group.cut && group.stepper == Stepper::Verlet;
  const bool drifts = !single.springs->damped && single.energyLimit.unsteady > 0.0;
  const bool inexact = cut || drifts || bounces(single.contacts) || isAboveBound(single.energyLimit);
  const bool lasting = inexact && areSurfacesAtRest(single.contacts);
  const bool isFolded = single.volumes.farFromRest || single.tetrahedra.farFromRest;
  const bool once = !anyNear(single) && isFolded;
  const bool free = (lasting || once) && isFreeBody(group);
  guard(group, free && lasting, free && once);
  for (SoftBodyData* body : group.bodies)
    if (body->energyLimit.on && !lasting) body->energyLimit.forceScaled = isForceScaled(group, tick);
}

/// Removes `energy` (J) from the whole motion. Returns the part that exceeds the kinetic energy.
double slowDown(PointState& points, double energy) {
  const double there = kineticEnergy(points), taken = std::min(energy, there);
  if (taken > 0.0) points.velocity *= std::sqrt(1.0 - taken / there);
  return energy - taken;
}

/// Removes the rise of the energy, less the work of the constant accelerations, from the motion.
void endEnergyLimit(LinkedGroup& group, double tick) {
  if (group.bodies.size() != 1) return;
  SoftBodyData& body = *group.bodies[0];
  EnergyLimit& limit = body.energyLimit;
  if (!limit.on || !(limit.persists || limit.forceScaled || isForceScaled(group, tick))) return;
  for (Eigen::Index i = 0; i < body.state.position.cols(); ++i)
    limit.bound +=
        massOf(body.state.inverseMass, i) *
        body.state.acceleration.col(i).dot(body.state.position.col(i) - body.masses.startPosition.col(i));
  SolverBody& stepped = group.step.bodies[0];
  if (stepped.drag) limit.bound += stepped.drag->work;
  limit.atEnd = energyOf(stepped);
  const double excess = limit.atEnd - limit.bound;
  if (!(excess > 0.0)) return;
  body.sumsValid = false;
  double left = removeKineticEnergy(*stepped.points, excess);
  // the rest is in the rigid motion: only contacts can have added it
  if (!body.contacts.empty()) left = slowDown(*stepped.points, left);
  limit.atEnd -= excess - left;
}

// --- one group ---------------------------------------------------------------------------------------------

/// Steps the group. With a tolerance, adds substeps and repeats it if the error is larger than predicted.
void stepToTolerance(LinkedGroup& group, double tick, SharedFactors& factors) {
  keepSprings(group);
  stepOnce(group, tick, factors);
  if (!hasTolerance(group) || !group.step.links.rigids.empty()) return;
  SteppingProblem problem = problemOf(group, tick);
  for (int i = 0; i < kMaxRetries; ++i) {
    problem.errorCoefficient = std::max(problem.errorCoefficient, errorCoefficient(group, tick));
    const SteppingChoice choice = limber::chooseStepping(problem, group.stepping);
    if (choice.substeps <= group.substeps) return;
    setChoice(group, choice);
    rewind(group, tick);
    stepOnce(group, tick, factors);
  }
}

}  // namespace

bool hasTolerance(const LinkedGroup& group) {
  const Stepping& s = group.stepping;
  return s.tolerance > 0.0 || s.relativeTolerance > 0.0;
}

void stepAlone(LinkedGroup& group, double tick, SharedFactors& factors) {
  stepToTolerance(group, tick, factors);
  repeatIfMissed(group, tick, factors);
}

void repeatIfMissed(LinkedGroup& group, double tick, SharedFactors& factors) {
  bool missed = false;
  for (SoftBodyData* body : group.bodies) missed = mayHaveMissedContacts(*body) || missed;
  if (!missed) return;
  rewind(group, tick);
  stepToTolerance(group, tick, factors);
}

bool areSurfacesAtRest(const std::vector<PlaneContact>& rows) {
  const auto isStill = [](const PlaneContact& row) { return row.surfaceVelocity.isZero(0.0); };
  return std::all_of(rows.begin(), rows.end(), isStill);
}

namespace {

/// Measures the work of drag on bodies with an energy limit, or on all.
void measureDrag(LinkedGroup& group, bool all) {
  for (std::size_t i = 0; i < group.bodies.size(); ++i)
    if (PointDrag* drag = group.step.bodies[i].drag)
      drag->measured = all || group.bodies[i]->energyLimit.on || group.bodies[i]->medium->hasWaterMass;
}

/// Takes over what the budget has resolved before the groups were made again.
void takeResolved(LinkedGroup& group) {
  const int budget = group.stepping.maxSubsteps > 0 ? group.stepping.maxSubsteps : kMaxSubsteps;
  for (const SoftBodyData* body : group.bodies)
    if (body->resolved > 0.0 && body->resolvedBy == budget)
      group.resolved = group.resolved > 0.0 ? std::min(group.resolved, body->resolved) : body->resolved;
}

/// Returns whether a body or link needs more substeps than any tick has, or has needed them before.
bool isTooFast(LinkedGroup& group, double tick) {
  if (group.resolved > 0.0) return true;
  const double limit = kBudgetPhaseSquared * std::pow(kMaxSubsteps / tick, 2);
  for (SoftBodyData* body : group.bodies) {
    if (body->frequencyStale) updateBounds(*body);
    if (body->frequencySquared > limit) return true;
  }
  return !group.springs.empty() && linkFrequencyBoundSquared(group.step.links) > limit;
}

}  // namespace

/// Links have at most half of the square of the frequency. Without a budget, bodies that need more substeps
/// than any tick has are softened to these.
void keepBudget(LinkedGroup& group, double tick) {
  group.stepping = strictest(group);
  if (group.resolved == 0.0) takeResolved(group);
  if (group.stepping.maxSubsteps == 0 && isTooFast(group, tick)) group.stepping.maxSubsteps = kMaxSubsteps;
  double largest = kBudgetPhaseSquared * std::pow(group.stepping.maxSubsteps / tick, 2);
  if (group.resolved > 0.0) largest = std::min(largest, group.resolved);
  group.resolved = largest;
  for (SoftBodyData* body : group.bodies)
    body->resolved = largest, body->resolvedBy = group.stepping.maxSubsteps;
  const auto scaleLinks = [&](double share) {
    for (std::size_t i = 0; i < group.springs.size(); ++i)
      setStiffness(group.step.links.springs[i], *group.springs[i], share);
  };
  double links = 0.0;
  if (largest > 0.0 && !group.springs.empty()) {
    scaleLinks(1.0);
    const double full = linkFrequencyBoundSquared(group.step.links);
    links = std::min(full, 0.5 * largest);
    if (links < full) scaleLinks(links / full);
  }
  for (SoftBodyData* body : group.bodies) soften(*body, largest - links, tick);
}

void chooseStepping(LinkedGroup& group, double tick) {
  SteppingProblem problem = problemOf(group, tick);
  setChoice(group, limber::chooseStepping(problem, group.stepping));
  for (SoftBodyData* body : group.bodies) body->prefersImplicit = group.stepper != Stepper::Verlet;
  if (group.inIsland && group.stepper != Stepper::Verlet) {
    problem.implicitPossible = false;
    setChoice(group, limber::chooseStepping(problem, group.stepping));
  }
  for (SoftBodyData* body : group.bodies) followTick(body->energyLimit, tick);
  startEnergyLimit(group, tick);
  measureDrag(group, false);
  // other bodies may move it farther than was predicted for the body alone
  const bool together = group.inIsland || !isPlain(group.step);
  for (SoftBodyData* body : group.bodies) {
    body->startVelocity = body->state.velocity;
    body->sumsValid = false;
    body->watch->on = body->settings.continuousCollision && (body->watch->on || together);
  }
}

void limitIslandEnergy(LinkedGroup& group, bool alone, bool bouncing, bool joined) {
  const auto isInexact = [&] {
    const SoftBodyData& body = *group.bodies[0];
    return bouncing || group.stepping.maxSubsteps > 0 || bounces(body.contacts) ||
           isAboveBound(body.energyLimit);
  };
  guard(group, alone && isInexact() && isFreeBody(group), false);
  measureDrag(group, joined);
}

std::size_t springCount(const std::vector<SoftBodyData*>& bodies) {
  std::size_t springs = 0;
  for (const SoftBodyData* body : bodies) springs += body->springs.size();
  return springs;
}

double workOf(const LinkedGroup& group) { return double(springCount(group.bodies)) * group.substeps; }

// --- after the step ----------------------------------------------------------------------------------------

void reportStepping(LinkedGroup& group, double tick) {
  constexpr double kErrorMemory = 0.25;  // s, the time in which a peak of the error fades
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
