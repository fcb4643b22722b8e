// SPDX-License-Identifier: Zlib
// Steps a single soft body, or several together, by velocity Verlet.
#include "solver/verlet_step.h"

#include "solver/lane_kernels.h"
#include "solver/simd_steps.h"

namespace limber {

void computeElasticForces(SolverBody& body, double crossing) {
  computeSpringForces(*body.springs, *body.points, crossing);
  if (body.volumes) addVolumeForces(*body.volumes, *body.points);
  if (body.tetrahedra) addTetrahedronForces(*body.tetrahedra, *body.points);
}

double elasticEnergy(SolverBody& body, const Points& position) {
  return elasticEnergy(*body.springs, position) +
         (body.volumes ? volumeEnergy(*body.volumes, position) : 0.0) +
         (body.tetrahedra ? tetrahedronEnergy(*body.tetrahedra, position) : 0.0);
}

void prepareVolumes(SolverBody& body, double dt) {
  if (body.volumes) body.volumes->timeStep = dt;
  if (body.tetrahedra) prepareTetrahedra(*body.tetrahedra, dt);
}

double verletErrorRate(double change, Eigen::Index points, double dt) {
  return dt / 24.0 * std::sqrt(change / static_cast<double>(std::max<Eigen::Index>(points, 1)));
}

MotionSums motionSums(const PointState& state, const Points& start, const RestShape& rest) {
  MotionSums sums;
  kernel::sumUp(kernel::MovedPoints<double>{
      static_cast<kernel::Index>(state.position.cols()), state.position.data(), state.velocity.data(),
      state.inverseMass.data(), start.data(), rest.fractions.data(), rest.weighted.data(), &sums});
  return sums;
}

// --- a single body -----------------------------------------------------------------------------------------

kernel::Body<double> kernelBody(SolverBody& body) {
  SpringArrays& springs = *body.springs;
  kernel::Body<double> b{};
  b.springs = kernelSprings(springs);
  b.points = kernelPoints(*body.points);
  if (body.volumes) b.volumes = kernelVolumes(*body.volumes);
  if (body.tetrahedra) b.tetrahedra = kernelTetrahedra(*body.tetrahedra);
  b.sweeps = springs.sweeps;
  b.dampHalf = springs.dampHalf.data(), b.dampFull = springs.dampFull.data();
  b.earlierForce = body.points->earlierForce.data();
  return b;
}

namespace {

/// The contacts and the drag of a body that is stepped alone.
struct BodyContacts final : kernel::ContactCalls {
  SolverBody& body;
  const PointView points;

  /// `view` must hold the state at the start of the tick.
  BodyContacts(SolverBody& stepped, const PointView& view) : body(stepped), points(view) {
    if (mayTouch(body) && body.contacts) prepareContacts(*body.contacts, points);
  }
  bool areThere() const { return mayTouch(body) || body.drag; }
  void stop(double time, double dt) override { solvePositions(body, points, time, dt); }
  void drag(double dt) override { applyDrag(body, points, dt); }
  void settle() override { solveVelocities(body, points); }
};

/// Decides where the body's state is in the step, and brings it there.
BatchedBody loaded(SolverBody& body) {
  if (body.springBatches && !(*body.springs)->limited) return {&body, true, loadSpringBatches(body)};
  body.points->allocateForces();
  body.springs->allocateDirections();
  return {&body, false, {kernelBody(body), nullptr, {}}};
}

PointView viewOf(const BatchedBody& body) {
  return body.inBatches ? viewOf(*body.stepped->springBatches) : viewOf(*body.stepped->points);
}

void stepSingle(SolverBody& body, double tick, int substeps) {
  BatchedBody stepped = loaded(body);
  BodyContacts contacts(body, viewOf(stepped));
  if (contacts.areThere()) stepped.arrays.contacts = &contacts;
  if (stepped.inBatches) packPlanes(body);
  const double change = stepped.inBatches
                            ? kernel::stepSpringBatches(stepped.arrays, tick, substeps)
                            : kernel::stepAlone<double, kernel::Body<double>>(stepped.arrays, tick, substeps);
  if (stepped.inBatches) unloadSpringBatches(body);
  body.errorRate = verletErrorRate(change, body.points->position.cols(), tick / substeps);
}

// --- a part of a body --------------------------------------------------------------------------------------

using kernel::StripBody;

kernel::BatchPoints pointsOf(const BatchedBody& body, const BodyPart& part) {
  if (part.isWhole()) return {0, body.arrays.points.count};
  return {part.begin, part.end, (*body.stepped->springs)->division.points.data()};
}

/// Returns the slots of a part of a divided body; none without strips.
kernel::BatchPoints slotsOf(const BatchedBody& body, const BodyPart& part) {
  const Division& division = (*body.stepped->springs)->division;
  if (division.strips.length == 0) return {0, 0};
  std::size_t slab = 0;
  while (division.pointRanges[slab].begin != part.begin) ++slab;
  return {division.slotRanges[slab].begin, division.slotRanges[slab].end, division.slots.data()};
}

void kick(BatchedBody& body, const BodyPart& part, double dt) {
  if (!body.inBatches) return body.arrays.kick(dt);
  kernel::kickBatchPoints(body.arrays, dt, pointsOf(body, part));
}

void drift(BatchedBody& body, const BodyPart& part, double dt) {
  if (!body.inBatches) return body.arrays.drift(dt);
  kernel::driftBatchPoints(body.arrays, dt, pointsOf(body, part));
}

void damp(BatchedBody& body, const BodyPart& part, bool whole, bool forward) {
  if (!body.inBatches) return body.arrays.damp(whole, forward);
  if (part.isWhole()) return kernel::dampBatch(body.arrays, whole, forward);
  kernel::dampBatchSprings(body.arrays, whole, forward, part.begin, part.end);
}

// --- islands -----------------------------------------------------------------------------------------------

/// Returns the batches of springs or tetrahedra of a range as a part. The last range of `count` elements
/// includes those that fill up the last batch.
BodyPart partOf(std::uint32_t number, const Division& division, const Range& range, std::uint32_t count) {
  const std::vector<std::uint32_t>& places = division.strips.places;
  if (places.empty()) return {number, range.begin, range.end == division.order.size() ? count : range.end};
  if (range.begin == range.end) return {number, 0, 0};
  return {number, places[range.begin] / 4 * 4, (places[range.end - 1] / 4 + 1) * 4};
}

/// Adds the parts of a divided body.
void addParts(std::uint32_t number, const BatchedBody& body, StepParts& parts) {
  const auto addRanges = [&](const Division& division, std::uint32_t count, auto& phases) {
    for (std::size_t phase = 0; phase < Division::kPhases; ++phase)
      for (const Range& range : division.phases[phase])
        phases[phase].push_back(partOf(number, division, range, count));
  };
  const SolverBody& b = *body.stepped;
  const Division& springs = (*b.springs)->division;
  addRanges(springs, body.arrays.springs.count, parts.springs);
  if (b.tetrahedra) addRanges((*b.tetrahedra)->division, body.arrays.tetrahedra.count, parts.tetrahedra);
  for (const Range& range : springs.pointRanges) parts.points.push_back({number, range.begin, range.end});
  const auto points = static_cast<std::uint32_t>(b.points->position.cols());
  parts.divided.push_back(number);
  if (!mayTouch(b)) return;
  for (std::uint32_t i = 0; i < points; i += kContactPoints)
    parts.contacts.push_back({number, i, std::min(i + kContactPoints, points)});
}

void makeParts(SolverIsland& group) {
  StepParts& parts = group.parts;
  parts.points.clear();
  parts.contacts.clear();
  parts.divided.clear();
  for (auto* phases : {&parts.springs, &parts.tetrahedra})
    for (std::vector<BodyPart>& phase : *phases) phase.clear();
  const auto isDivided = [&](const BatchedBody& body) {
    return group.team && body.inBatches && (*body.stepped->springs)->division.isDivided();
  };
  for (std::uint32_t i = 0; i < group.inStep.size(); ++i) {
    if (isDivided(group.inStep[i])) continue;
    parts.points.push_back({i});
    parts.springs[0].push_back({i});
  }
  for (std::uint32_t i = 0; i < group.inStep.size(); ++i)
    if (isDivided(group.inStep[i])) addParts(i, group.inStep[i], parts);
}

/// Loads the bodies, and divides large ones among the threads.
void load(SolverIsland& group) {
  group.inStep.clear();
  group.links.views.clear();
  for (SolverBody& body : group.bodies) {
    group.inStep.push_back(loaded(body));
    group.links.views.push_back(viewOf(group.inStep.back()));
  }
  makeParts(group);
}

void unload(SolverIsland& group) {
  for (BatchedBody& body : group.inStep)
    if (body.inBatches) unloadSpringBatches(*body.stepped);
  group.links.views.clear();
}

/// Calls visit(body, part) for all parts, on all threads.
template <class Visit>
void forEach(SolverIsland& group, Team& team, const std::vector<BodyPart>& parts, Visit visit) {
  team.forEach(static_cast<std::uint32_t>(parts.size()),
               [&](std::uint32_t i) { visit(group.inStep[parts[i].body], parts[i]); });
}

void keepForces(SolverIsland& group) {
  for (std::size_t i = 0; i < group.bodies.size(); ++i) {
    const PointView& p = group.links.views[i];
    std::copy_n(p.force, p.pointStride * group.bodies[i].points->position.cols(), p.earlierForce);
  }
}

/// Returns the sum over the points of the squared change of acceleration since keepForces(), with the bits of
/// computeForcesAndChange() of verlet_kernel.h.
double squaredChange(const PointView& p, Eigen::Index points) {
  double sum[3] = {};
  for (Eigen::Index i = 0; i < points; ++i)
    for (Eigen::Index c = 0; c < 3; ++c) {
      const Eigen::Index at = p.pointStride * i + c;
      const double change = (p.force[at] - p.earlierForce[at]) * p.inverseMass[at];
      sum[c] += change * change;
    }
  return sum[0] + (sum[1] + sum[2]);
}

void estimateErrors(SolverIsland& group, double dt) {
  for (std::size_t i = 0; i < group.bodies.size(); ++i) {
    SolverBody& body = group.bodies[i];
    const Eigen::Index points = body.points->position.cols();
    const double rate = verletErrorRate(squaredChange(group.links.views[i], points), points, dt);
    body.errorRate = std::max(body.errorRate, rate);
  }
}

/// Loads or unloads a quantity of the slots of divided bodies, on all threads.
void moveSlots(SolverIsland& group, Team& team, decltype(kernel::loadSlots) move, unsigned quantity) {
  if (group.parts.divided.empty()) return;
  forEach(group, team, group.parts.points, [&](BatchedBody& body, const BodyPart& part) {
    if (!part.isWhole()) move(body.arrays, slotsOf(body, part), quantity);
  });
}

/// Computes the forces of a whole body. Clears those of a part of a divided one, and adds those of its
/// springs of the first phase: the springs inside a slab need no other slab.
void startForces(SolverIsland& group, std::uint32_t i, double crossing) {
  const BodyPart &points = group.parts.points[i], &springs = group.parts.springs[0][i];
  BatchedBody& body = group.inStep[points.body];
  if (!body.inBatches) return computeElasticForces(*body.stepped, crossing);
  if (points.isWhole()) return kernel::computeBatchForces(body.arrays, crossing);
  kernel::clearBatchForces(body.arrays, pointsOf(body, points));
  kernel::loadSlots(body.arrays, slotsOf(body, points), StripBody::kPosition);
  kernel::addBatchSprings(body.arrays, springs.begin, springs.end, crossing);
}

/// Adds all forces but those of startForces().
void addOtherForces(SolverIsland& group, Team& team, double dt, double crossing) {
  for (std::size_t phase = 1; phase < Division::kPhases; ++phase)
    forEach(group, team, group.parts.springs[phase], [&](BatchedBody& body, const BodyPart& part) {
      kernel::addBatchSprings(body.arrays, part.begin, part.end, crossing);
    });
  moveSlots(group, team, kernel::unloadSlots, StripBody::kForce);
  team.forEach(static_cast<std::uint32_t>(group.parts.divided.size()), [&](std::uint32_t i) {
    kernel::addBatchVolumes(group.inStep[group.parts.divided[i]].arrays);
  });
  for (const std::vector<BodyPart>& phase : group.parts.tetrahedra)
    forEach(group, team, phase, [](BatchedBody& body, const BodyPart& part) {
      kernel::addBatchTetrahedra(body.arrays, part.begin, part.end);
    });
  for (RigidState& rigid : group.links.rigids) {
    rigid.force.setZero();
    rigid.torque.setZero();
  }
  addLinkForces(group.links, dt, crossing);
}

/// Drifts, and computes the forces at the new positions, with this share of kernel::crossingForce().
void driftAndComputeForces(SolverIsland& group, Team& team, double dt, double crossing) {
  StepParts& parts = group.parts;
  team.forEach(static_cast<std::uint32_t>(parts.points.size()), [&](std::uint32_t i) {
    drift(group.inStep[parts.points[i].body], parts.points[i], dt);
    startForces(group, i, crossing);
  });
  for (RigidState& rigid : group.links.rigids) rigid.drift(dt);
  driftLinks(group.links, dt);
  addOtherForces(group, team, dt, crossing);
}

/// Computes the forces at the start of the tick.
void computeForces(SolverIsland& group, Team& team, double dt) {
  StepParts& parts = group.parts;
  team.forEach(static_cast<std::uint32_t>(parts.points.size()),
               [&](std::uint32_t i) { startForces(group, i, kernel::kFirstCrossing); });
  addOtherForces(group, team, dt, kernel::kFirstCrossing);
}

/// Applies the dampers of bodies that need more than `sweep` sweeps.
void dampInSweep(SolverIsland& group, Team& team, int sweep, bool whole, bool forward) {
  for (std::size_t k = 0; k < Division::kPhases; ++k)
    forEach(group, team, group.parts.springs[forward ? k : Division::kPhases - 1 - k],
            [&](BatchedBody& body, const BodyPart& part) {
              if (sweep < body.stepped->springs->sweeps) damp(body, part, whole, forward);
            });
}

/// See dampInSweeps() of verlet_kernel.h.
void damp(SolverIsland& group, Team& team, double dt, bool whole, bool forward) {
  int sweeps = 0;
  for (const SolverBody& body : group.bodies) sweeps = std::max(sweeps, body.springs->sweeps);
  moveSlots(group, team, kernel::loadSlots, StripBody::kVelocity);
  for (int sweep = 0; sweep < sweeps; ++sweep)
    dampInSweep(group, team, sweep, whole, (sweep % 2 == 0) == forward);
  moveSlots(group, team, kernel::unloadSlots, StripBody::kVelocity);
  dampLinks(group.links, whole ? dt : 0.5 * dt, forward);
}

/// Half a kick, then the contacts of points before the drift.
void kickAndStop(SolverIsland& group, Team& team, double time, double dt) {
  const std::vector<PointView>& views = group.links.views;
  forEach(group, team, group.parts.points, [&](BatchedBody& body, const BodyPart& part) {
    kick(body, part, 0.5 * dt);
    if (part.isWhole()) solvePositions(*body.stepped, views[part.body], time, dt);
  });
  std::atomic<bool> anyLeaves{false};
  forEach(group, team, group.parts.contacts, [&](BatchedBody& body, const BodyPart& part) {
    const SolverBody& b = *body.stepped;
    const PointView& points = views[part.body];
    if (b.contacts)
      limber::solvePositions(ContactRows(*b.contacts, b.packed, part.begin, part.end), points, time, dt);
    if (b.watch && b.watch->on && b.watch->anyLeaves(points, dt, part.begin, part.end)) anyLeaves = true;
  });
  for (const std::uint32_t i : group.parts.divided)
    solveUnpredicted(group.bodies[i], views[i], time, dt, anyLeaves);
  for (RigidState& rigid : group.links.rigids) rigid.kick(0.5 * dt);
}

/// The other half, drag, and the same contacts after it.
void kickAndSettle(SolverIsland& group, Team& team, double dt) {
  const std::vector<PointView>& views = group.links.views;
  forEach(group, team, group.parts.points, [&](BatchedBody& body, const BodyPart& part) {
    kick(body, part, 0.5 * dt);
    if (!part.isWhole()) return;
    applyDrag(*body.stepped, views[part.body], dt);
    solveVelocities(*body.stepped, views[part.body]);
  });
  for (const std::uint32_t i : group.parts.divided) applyDrag(group.bodies[i], views[i], dt);
  forEach(group, team, group.parts.contacts, [&](BatchedBody& body, const BodyPart& part) {
    const SolverBody& b = *body.stepped;
    if (b.contacts)
      limber::solveVelocities(ContactRows(*b.contacts, b.packed, part.begin, part.end), views[part.body]);
  });
  for (const std::uint32_t i : group.parts.divided) settleUnpredicted(group.bodies[i], views[i]);
  for (RigidState& rigid : group.links.rigids) rigid.kick(0.5 * dt);
}

void prepare(SolverIsland& group) {
  load(group);
  for (std::size_t i = 0; i < group.bodies.size(); ++i) {
    group.bodies[i].errorRate = 0.0;
    if (group.bodies[i].contacts) prepareContacts(*group.bodies[i].contacts, group.links.views[i]);
    if (group.inStep[i].inBatches) packPlanes(group.bodies[i]);
  }
  for (RigidState& rigid : group.links.rigids) rigid.turn();
  fitFrames(group.links);
  prepareAnchors(group.links);
  for (Contact& c : group.pairs.contacts) c.impulse = TickImpulse();
  for (JointConstraint& j : group.pairs.joints) j.impulse = j.work = 0.0;
  group.pairs.time = 0.0;
  group.pairs.rows.clear();  // those of the last tick
  startTurning(group.pairs, group.links);
  prepareConstraints(group.pairs, group.links);
}

/// Repeats the search for contacts if it is due. Call it before each substep.
void searchAgain(SolverIsland& group, Team& team, int substep, int substeps, double dt) {
  const PairSearch& again = group.again;
  if (again.every == 0 || substep == 0 || substep % again.every != 0) return;
  finishConstraints(group.pairs);
  for (SolverBody& body : group.bodies)
    if (body.packed) unpackPlanes(*body.packed, *body.contacts);
  again.search(again.context, group, team, dt * substep, dt * std::min(again.every, substeps - substep));
  prepareConstraints(group.pairs, group.links);
}

/// Implements stepVerlet() for bodies that links, contacts or joints couple, or that several threads step.
/// Their dampers and volume terms must be prepared. While no coupling acts on a body, its results equal those
/// of a single body, to the bit.
void stepLinked(SolverIsland& group, Team& team, double tick, int substeps) {
  const double dt = tick / substeps;
  prepare(group);
  computeForces(group, team, dt);
  joinVelocities(group.links);
  damp(group, team, dt, false, false);
  for (int s = 0; s < substeps; ++s) {
    const bool last = s + 1 == substeps;
    searchAgain(group, team, s, substeps, dt);
    turnSurfaces(group.pairs, (s + 0.5) * dt);
    kickAndStop(group, team, s * dt, dt);
    followContacts(group.pairs, group.links, team, dt);
    fitFrames(group.links);
    turnJoints(group.pairs, group.links, dt, JointPivots::Shared);
    solvePositions(group.pairs, group.links, team, dt, tick);
    updateGaps(group.pairs, team, dt);
    const bool estimates = last || 2 * s == substeps;
    if (estimates) keepForces(group);
    driftAndComputeForces(group, team, dt, last ? kernel::kLastCrossing : kernel::kCrossing);
    if (estimates) estimateErrors(group, dt);
    // anchors and contacts before dampers: these must not use the velocity of a point that the kick moves
    // away from its anchor or contact
    kickAndSettle(group, team, dt);
    followContacts(group.pairs, group.links, team, 0.0);
    fitFrames(group.links);
    turnJoints(group.pairs, group.links, 0.0, JointPivots::Shared);
    solveVelocities(group.pairs, group.links, team);
    sumAnchorImpulses(group.links);
    // the half dampings of two successive substeps act at the same positions, so a full one replaces them
    damp(group, team, dt, !last, s % 2 == 0);
  }
  joinVelocities(group.links);
  finishConstraints(group.pairs);
  unload(group);
}

}  // namespace

// --- the step ----------------------------------------------------------------------------------------------

bool isPlain(const SolverIsland& group) {
  const LinkedBodies& links = group.links;
  return group.bodies.size() == 1 && group.pairs.empty() && links.springs.empty() && links.anchors.empty() &&
         links.rigids.empty() && !(*group.bodies[0].springs)->limited;
}

void stepVerlet(SolverIsland& group, double tick, int substeps) {
  for (SolverBody& body : group.bodies) {
    prepareSprings(*body.springs, body.points->inverseMass, tick / substeps);
    prepareVolumes(body, tick / substeps);
    startDrag(body);
  }
  if (isPlain(group) && group.again.every == 0 && !group.team)
    return stepSingle(group.bodies[0], tick, substeps);
  Team alone;
  stepLinked(group, group.team ? *group.team : alone, tick, substeps);
}

}  // namespace limber
