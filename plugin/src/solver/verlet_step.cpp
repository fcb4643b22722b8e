// SPDX-License-Identifier: Zlib
#include "solver/verlet_step.h"

#include "solver/body_contacts.h"
#include "solver/kernel_views.h"
#include "solver/linked_step.h"
#include "solver/quad_step.h"
#include "solver/spring_damping.h"

#include <algorithm>
#include <cmath>

namespace limber {
namespace {

void stepSingle(SteppedBody& body, double tick, int substeps) {
  if (body.quads) return stepQuads(body, tick, substeps);
  PointState& state = *body.points;
  SpringArrays& springs = *body.springs;
  BodyContacts contacts{&body, viewOf(state)};
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
  if (isPlain(group) && group.again.every == 0)
    stepSingle(group.bodies[0], tick, substeps);
  else
    stepLinked(group, tick, substeps);
}

}  // namespace limber
