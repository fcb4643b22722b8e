// SPDX-License-Identifier: Zlib
#pragma once

#include "solver/implicit_state.h"
#include "solver/verlet_step.h"

namespace limber {

/// A substep of the implicit midpoint rule as it is being solved: body.points->position is the midpoint x
/// that the iterations work on.
struct Substep {
  SteppedBody& body;
  ImplicitState& implicit;
  double time;         ///< s since the start of the tick
  double h;            ///< s, of the whole substep
  bool euler = false;     ///< only its first half, by backward Euler
  bool downhill = false;  ///< from x0 instead of from where the motion leads

  PointState& points() const { return *body.points; }
  SpringArrays& springs() const { return *body.springs; }
  ContactSpan whole() const { return {time, h, 2.0}; }
  ContactSpan firstHalf() const { return {time, 0.5 * h, 1.0}; }
  bool touches() const { return implicit.contacts.count > 0; }
};

/// Sets the points' forces to those of springs and dampers at x. The dampers turn with their springs if they
/// are told to: in the first iterations only, since under strong damping changing directions would not
/// converge.
void computeForces(const Substep& substep, bool turnDampers);

/// Sets implicit.residual to  M (y - x) + h^2/4 f(x) + loads  (implicit_step.h), 0 for held points.
void computeResidual(const Substep& substep);

/// What the iterations descend on when nothing touches: |x - y|_M^2 / 2 + h^2/4 E(x) and the dampers' part.
double objective(const Substep& substep, const Points& position);

}  // namespace limber
