// SPDX-License-Identifier: Zlib
#include "core/verlet_step.h"

#include "core/spring_damping.h"
#include "core/spring_forces.h"

namespace limber {
namespace {

void computeForces(StepGroup& group) {
  for (SteppedBody& body : group.bodies) {
    body.points->force.setZero();
    addSpringForces(*body.springs, *body.points);
  }
  for (RigidState& rigid : group.links.rigids) {
    rigid.force.setZero();
    rigid.torque.setZero();
  }
  addLinkForces(group.links);
}

void kick(StepGroup& group, double dt) {
  for (SteppedBody& body : group.bodies) {
    PointState& p = *body.points;
    p.velocity += dt * (p.acceleration + p.force.cwiseProduct(p.inverseMass));
  }
  for (RigidState& rigid : group.links.rigids) rigid.kick(dt);
}

void drift(StepGroup& group, double dt) {
  for (SteppedBody& body : group.bodies) body.points->position += dt * body.points->velocity;
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
    if (body.contacts) stopAtContacts(*body.contacts, *body.points, time, dt);
}

void settleContacts(StepGroup& group) {
  for (SteppedBody& body : group.bodies)
    if (body.contacts) settleContacts(*body.contacts, *body.points);
}

}  // namespace

void stepVerlet(StepGroup& group, double tick, int substeps) {
  const double dt = tick / substeps;
  for (SteppedBody& body : group.bodies) prepareDampers(*body.springs, body.points->inverseMass, dt);
  computeForces(group);
  solveAnchors(group.links, 0.0);
  damp(group, dt, false, false);
  for (int s = 0; s < substeps; ++s) {
    const bool last = s + 1 == substeps;
    kick(group, 0.5 * dt);
    solveAnchors(group.links, dt);
    stopAtContacts(group, s * dt, dt);
    drift(group, dt);
    computeForces(group);
    kick(group, 0.5 * dt);
    // first anchors and contacts: a damper must not see a point kicked away from what holds it
    solveAnchors(group.links, 0.0);
    settleContacts(group);
    // the half dampings of neighbouring substeps act at the same positions and merge into one
    damp(group, dt, !last, s % 2 == 0);
  }
  solveAnchors(group.links, 0.0);
}

}  // namespace limber
