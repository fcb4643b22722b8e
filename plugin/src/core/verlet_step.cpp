// SPDX-License-Identifier: Zlib
#include "core/verlet_step.h"

#include "core/body_contacts.h"
#include "core/kernel_views.h"
#include "core/pair_solve.h"
#include "core/quad_step.h"
#include "core/spring_damping.h"
#include "core/spring_forces.h"

#include <algorithm>
#include <cmath>

namespace limber {
namespace {

void stepSingle(SteppedBody& body, double tick, int substeps) {
  if (body.quads) return stepQuads(body, tick, substeps);
  PointState& state = *body.points;
  SpringArrays& springs = *body.springs;
  BodyContacts contacts{body.contacts, viewOf(state)};
  const kernel::ContactCalls calls = contacts.calls();
  const double change = kernel::stepAlone<double>(
      kernel::Body<double>{
          kernelSprings(springs), kernelPoints(state),
          body.volumes ? kernelVolumes(*body.volumes) : kernel::Volumes<double>{},
          body.tetrahedra ? kernelTetrahedra(*body.tetrahedra) : kernel::Tetrahedra<double>{}, springs.damped,
          springs.dampHalf.data(), springs.dampFull.data(), &calls, state.earlierForce.data()},
      tick, substeps);
  body.errorRate = verletErrorRate(change, state.position.cols(), tick / substeps);
}

void computeForces(StepGroup& group) {
  for (SteppedBody& body : group.bodies) {
    computeElasticForces(body);
  }
  for (RigidState& rigid : group.links.rigids) {
    rigid.force.setZero();
    rigid.torque.setZero();
  }
  addLinkForces(group.links);
}

void kick(StepGroup& group, double dt) {
  for (SteppedBody& body : group.bodies) kernel::kick(kernelPoints(*body.points), dt);
  for (RigidState& rigid : group.links.rigids) rigid.kick(dt);
}

void drift(StepGroup& group, double dt) {
  for (SteppedBody& body : group.bodies) kernel::drift(kernelPoints(*body.points), dt);
  for (RigidState& rigid : group.links.rigids) rigid.drift(dt);
}

void damp(StepGroup& group, double dt, bool whole, bool forward) {
  const SweepOrder order = forward ? SweepOrder::Forward : SweepOrder::Backward;
  for (SteppedBody& body : group.bodies)
    dampSprings(*body.springs, whole ? body.springs->dampFull : body.springs->dampHalf, order, *body.points);
  dampLinks(group.links, whole ? dt : 0.5 * dt, forward);
}

void stopAtContacts(StepGroup& group, double time, double dt) {
  for (SteppedBody& body : group.bodies)
    if (body.contacts) stopAtContacts(*body.contacts, viewOf(*body.points), time, dt);
}

void settleContacts(StepGroup& group) {
  for (SteppedBody& body : group.bodies)
    if (body.contacts) settleContacts(*body.contacts, viewOf(*body.points));
}

void keepForces(StepGroup& group) {
  for (SteppedBody& body : group.bodies) body.points->earlierForce = body.points->force;
}

void estimateErrors(StepGroup& group, double dt) {
  for (SteppedBody& body : group.bodies) {
    const PointState& p = *body.points;
    const double change = (p.force - p.earlierForce).cwiseProduct(p.inverseMass).squaredNorm();
    body.errorRate = std::max(body.errorRate, verletErrorRate(change, p.position.cols(), dt));
  }
}

void stepLinked(StepGroup& group, double tick, int substeps) {
  const double dt = tick / substeps;
  for (SteppedBody& body : group.bodies) {
    body.errorRate = 0.0;
    if (body.contacts) prepareContacts(*body.contacts, viewOf(*body.points));
  }
  for (RigidState& rigid : group.links.rigids) rigid.turn();
  preparePairs(group.pairs, group.links);
  computeForces(group);
  solveAnchors(group.links, 0.0);
  damp(group, dt, false, false);
  for (int s = 0; s < substeps; ++s) {
    const bool last = s + 1 == substeps;
    kick(group, 0.5 * dt);
    solveAnchors(group.links, dt);
    stopAtContacts(group, s * dt, dt);
    stopPairs(group.pairs, group.links, dt);
    movePairs(group.pairs, group.links, dt);
    drift(group, dt);
    const bool estimates = last || 2 * s == substeps;
    if (estimates) keepForces(group);
    computeForces(group);
    if (estimates) estimateErrors(group, dt);
    kick(group, 0.5 * dt);
    // first anchors and contacts: a damper must not see a point kicked away from what holds it
    solveAnchors(group.links, 0.0);
    settleContacts(group);
    settlePairs(group.pairs, group.links);
    // the half dampings of neighbouring substeps act at the same positions and merge into one
    damp(group, dt, !last, s % 2 == 0);
  }
  solveAnchors(group.links, 0.0);
}

}  // namespace

double verletErrorRate(double change, Eigen::Index points, double dt) {
  return dt / 24.0 * std::sqrt(change / static_cast<double>(std::max<Eigen::Index>(points, 1)));
}

void prepareVolumes(SteppedBody& body, double dt) {
  if (body.volumes) body.volumes->timeStep = dt;
  if (body.tetrahedra) prepareTetrahedra(*body.tetrahedra, body.points->inverseMass, dt);
}

bool isPlain(const StepGroup& group) {
  const LinkedBodies& links = group.links;
  return group.bodies.size() == 1 && group.pairs.empty() && links.springs.empty() && links.anchors.empty() &&
         links.rigids.empty() && !group.bodies[0].springs->limited;
}

void stepVerlet(StepGroup& group, double tick, int substeps) {
  for (SteppedBody& body : group.bodies) {
    prepareDampers(*body.springs, body.points->inverseMass, tick / substeps);
    prepareVolumes(body, tick / substeps);
  }
  if (isPlain(group))
    stepSingle(group.bodies[0], tick, substeps);
  else
    stepLinked(group, tick, substeps);
}

}  // namespace limber
