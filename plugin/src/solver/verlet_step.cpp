// SPDX-License-Identifier: Zlib
// Steps a single soft body, or several together, by velocity Verlet.
#include "solver/verlet_step.h"

#include "solver/contacts.h"
#include "solver/simd_steps.h"

#include <algorithm>
#include <cmath>

namespace limber {

void computeElasticForces(SolverBody& body) {
  computeSpringForces(*body.springs, *body.points);
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
  if (body.tetrahedra) prepareTetrahedra(*body.tetrahedra, body.points->inverseMass, dt);
}

double verletErrorRate(double change, Eigen::Index points, double dt) {
  return dt / 24.0 * std::sqrt(change / static_cast<double>(std::max<Eigen::Index>(points, 1)));
}

MotionSums motionSums(const PointState& state, const Points& start, const RestShape& rest) {
  MotionSums sums;
  kernel::sumUp(
      kernel::MovedPoints<double>{static_cast<kernel::Index>(state.position.cols()), state.position.data(),
                                  state.velocity.data(), state.inverseMass.data(), start.data(),
                                  rest.fractions.data(), rest.weighted.data()},
      sums);
  return sums;
}

// --- a single body -----------------------------------------------------------------------------------------

namespace {

void stepSingle(SolverBody& body, double tick, int substeps) {
  if (body.springBatches) return stepSpringBatches(body, tick, substeps);
  PointState& state = *body.points;
  SpringArrays& springs = *body.springs;
  BodyContacts contacts{&body, viewOf(state), tick / substeps};
  const kernel::ContactCalls calls = contacts.calls();
  const double change = kernel::stepAlone<double>(
      kernel::Body<double>{
          kernelSprings(springs), kernelPoints(state),
          body.volumes ? kernelVolumes(*body.volumes) : kernel::Volumes<double>{},
          body.tetrahedra ? kernelTetrahedra(*body.tetrahedra) : kernel::Tetrahedra<double>{},
          springs->damped, springs.dampHalf.data(), springs.dampFull.data(), &calls,
          state.earlierForce.data()},
      tick, substeps);
  body.errorRate = verletErrorRate(change, state.position.cols(), tick / substeps);
}

// --- a body of an island: four springs at a time, or one by one --------------------------------------------

void computeForces(BatchedBody& body) {
  if (body.inBatches) return kernel::computeBatchForces(body.springBatches);
  computeElasticForces(*body.stepped);
}

void kick(BatchedBody& body, double dt) {
  if (body.inBatches) return kernel::kickSpringBatches(body.springBatches, dt);
  kernel::kick(kernelPoints(*body.stepped->points), dt);
}

void drift(BatchedBody& body, double dt) {
  if (body.inBatches) return kernel::driftSpringBatches(body.springBatches, dt);
  kernel::drift(kernelPoints(*body.stepped->points), dt);
}

void damp(BatchedBody& body, bool whole, bool forward) {
  if (body.inBatches) return kernel::dampSpringBatches(body.springBatches, whole, forward);
  SpringArrays& springs = *body.stepped->springs;
  dampSprings(springs, whole ? springs.dampFull : springs.dampHalf,
              forward ? SweepOrder::Forward : SweepOrder::Backward, *body.stepped->points);
}

// --- islands -----------------------------------------------------------------------------------------------

/// Decides where each body's state is in the step.
void load(SolverIsland& group) {
  group.inStep.clear();
  group.links.views.clear();
  for (SolverBody& body : group.bodies) {
    group.inStep.push_back({&body, body.springBatches && !(*body.springs)->limited, {}});
    BatchedBody& stepped = group.inStep.back();
    if (stepped.inBatches)
      stepped.springBatches = loadSpringBatches(body, nullptr);
    else
      body.points->allocateForces();
    group.links.views.push_back(stepped.inBatches ? viewOf(*body.springBatches) : viewOf(*body.points));
  }
}

void unload(SolverIsland& group) {
  for (BatchedBody& body : group.inStep)
    if (body.inBatches) unloadSpringBatches(*body.stepped);
  group.links.views.clear();
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

void computeForces(SolverIsland& group) {
  for (BatchedBody& body : group.inStep) computeForces(body);
  for (RigidState& rigid : group.links.rigids) {
    rigid.force.setZero();
    rigid.torque.setZero();
  }
  addLinkForces(group.links);
}

void kick(SolverIsland& group, double dt) {
  for (BatchedBody& body : group.inStep) kick(body, dt);
  for (RigidState& rigid : group.links.rigids) rigid.kick(dt);
}

void drift(SolverIsland& group, double dt) {
  for (BatchedBody& body : group.inStep) drift(body, dt);
  for (RigidState& rigid : group.links.rigids) rigid.drift(dt);
  driftLinks(group.links, dt);
}

void damp(SolverIsland& group, double dt, bool whole, bool forward) {
  for (BatchedBody& body : group.inStep) damp(body, whole, forward);
  dampLinks(group.links, whole ? dt : 0.5 * dt, forward);
}

void solvePositions(SolverIsland& group, double time, double dt) {
  for (std::size_t i = 0; i < group.bodies.size(); ++i)
    solvePositions(group.bodies[i], group.links.views[i], time, dt);
}

void applyDrag(SolverIsland& group, double dt) {
  for (std::size_t i = 0; i < group.bodies.size(); ++i) applyDrag(group.bodies[i], group.links.views[i], dt);
}

void solveVelocities(SolverIsland& group) {
  for (std::size_t i = 0; i < group.bodies.size(); ++i)
    solveVelocities(group.bodies[i], group.links.views[i]);
}

void prepare(SolverIsland& group) {
  load(group);
  for (std::size_t i = 0; i < group.bodies.size(); ++i) {
    group.bodies[i].errorRate = 0.0;
    if (group.bodies[i].contacts) prepareContacts(*group.bodies[i].contacts, group.links.views[i]);
  }
  for (RigidState& rigid : group.links.rigids) rigid.turn();
  prepareAnchors(group.links);
  for (Contact& c : group.pairs.contacts) c.impulse = TickImpulse();
  for (JointConstraint& j : group.pairs.joints) j.impulse = 0.0;
  prepareConstraints(group.pairs, group.links);
}

/// Repeats the search for contacts if it is due. Call it before each substep.
void searchAgain(SolverIsland& group, int substep, int substeps, double dt) {
  const PairSearch& again = group.again;
  if (again.every == 0 || substep == 0 || substep % again.every != 0) return;
  finishConstraints(group.pairs);
  again.search(again.context, group, dt * substep, dt * std::min(again.every, substeps - substep));
  prepareConstraints(group.pairs, group.links);
}

/// Implements stepVerlet() for bodies that links, contacts or joints couple. Their dampers and volume terms
/// must be prepared. While no coupling acts on a body, its results equal those of a single body, to the bit.
void stepLinked(SolverIsland& group, double tick, int substeps) {
  const double dt = tick / substeps;
  prepare(group);
  computeForces(group);
  joinVelocities(group.links);
  damp(group, dt, false, false);
  for (int s = 0; s < substeps; ++s) {
    const bool last = s + 1 == substeps;
    searchAgain(group, s, substeps, dt);
    kick(group, 0.5 * dt);
    solvePositions(group, s * dt, dt);
    followContacts(group.pairs, dt);
    solvePositions(group.pairs, group.links, dt, tick);
    updateGaps(group.pairs, dt);
    drift(group, dt);
    const bool estimates = last || 2 * s == substeps;
    if (estimates) keepForces(group);
    computeForces(group);
    if (estimates) estimateErrors(group, dt);
    kick(group, 0.5 * dt);
    applyDrag(group, dt);
    // anchors and contacts first: a damper must not use the velocity of a point that the kick moves away from
    // its anchor or contact
    solveVelocities(group);
    followContacts(group.pairs, 0.0);
    solveVelocities(group.pairs, group.links);
    sumAnchorImpulses(group.links);
    // the half dampings of two successive substeps act at the same positions, so a full one replaces them
    damp(group, dt, !last, s % 2 == 0);
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
    prepareDampers(*body.springs, body.points->inverseMass, tick / substeps);
    prepareVolumes(body, tick / substeps);
    startDrag(body);
  }
  if (isPlain(group) && group.again.every == 0)
    stepSingle(group.bodies[0], tick, substeps);
  else
    stepLinked(group, tick, substeps);
}

}  // namespace limber
