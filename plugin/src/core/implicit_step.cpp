// SPDX-License-Identifier: Zlib
#include "core/implicit_step.h"

#include "core/body_measures.h"
#include "core/energy_guard.h"
#include "core/midpoint_damping.h"
#include "core/spring_forces.h"

#include <algorithm>
#include <cmath>

namespace limber {
namespace {

/// Iterations end when no point moves by more than this share of the longest spring.
constexpr double kConverged = 1e-11;
constexpr int kMostSharedIterations = 10;
constexpr int kMostNewtonIterations = 12;

/// Halvings of a Newton step that would go uphill.
constexpr int kMostHalvings = 6;

struct Substep {
  SteppedBody& body;
  ImplicitState& implicit;
  double time, h;

  PointState& points() const { return *body.points; }
  SpringArrays& springs() const { return *body.springs; }
  bool touches() const { return implicit.contacts.load.cols() > 0; }
};

bool isHeld(const PointState& p, Eigen::Index i) { return p.inverseMass.col(i).maxCoeff() == 0.0; }

double massOf(const PointState& p, Eigen::Index i) { return 1.0 / p.inverseMass.col(i).maxCoeff(); }

/// y of implicit_step.h; held points go with their velocity.
Eigen::Vector3d inertialMidpoint(const Substep& s, Eigen::Index i) {
  return s.implicit.start.col(i) + 0.5 * s.h * s.implicit.startVelocity.col(i) +
         0.25 * s.h * s.h * s.points().acceleration.col(i);
}

void start(const Substep& s) {
  PointState& p = s.points();
  s.implicit.start = p.position;
  s.implicit.startVelocity = p.velocity;
  p.position += 0.5 * s.h * p.velocity;
}

/// Adds the dampers' forces for the velocities that the present midpoint positions mean.
void addDampingForces(const Substep& s) {
  const SpringArrays& springs = s.springs();
  PointState& p = s.points();
  if (!springs.damped) return;
  for (std::size_t i = 0; i < springs.size(); ++i) {
    const auto a = springs.a[i], b = springs.b[i];
    const double beta = lookAhead(springs.damping[i], inverseMassesOf(springs, p.inverseMass, i), s.h);
    const auto velocity = [&](std::uint32_t j) -> Eigen::Vector3d {
      const Eigen::Vector3d mean = 2.0 / s.h * (p.position.col(j) - s.implicit.start.col(j));
      return mean + beta * (mean - s.implicit.startVelocity.col(j));
    };
    const Eigen::Vector3d n = springs.direction.col(static_cast<Eigen::Index>(i));
    const Eigen::Vector3d force = springs.damping[i] * n.dot(velocity(b) - velocity(a)) * n;
    p.force.col(a) += force;
    p.force.col(b) -= force;
  }
}

void computeForces(const Substep& s) {
  computeSpringForces(s.springs(), s.points());
  addDampingForces(s);
}

/// M (y - x) + h^2/4 f(x) + loads.
void computeResidual(const Substep& s) {
  const PointState& p = s.points();
  Points& r = s.implicit.residual;
  for (Eigen::Index i = 0; i < p.position.cols(); ++i) {
    if (isHeld(p, i))
      r.col(i).setZero();
    else
      r.col(i) =
          massOf(p, i) * (inertialMidpoint(s, i) - p.position.col(i)) + 0.25 * s.h * s.h * p.force.col(i);
  }
  if (s.touches()) addLoads(s.implicit.contacts, s.implicit.contacts.load, r);
}

/// What the iterations descend on when nothing damps or touches: |x - y|_M^2 / 2 + h^2/4 E(x).
double objective(const Substep& s, const Points& position) {
  const PointState& p = s.points();
  double sum = 0.25 * s.h * s.h * elasticEnergy(s.springs(), position);
  for (Eigen::Index i = 0; i < position.cols(); ++i)
    if (!isHeld(p, i)) sum += 0.5 * massOf(p, i) * (position.col(i) - inertialMidpoint(s, i)).squaredNorm();
  return sum;
}

/// Newton's method may overshoot where springs are strongly compressed.
void shortenStep(const Substep& s) {
  if (s.implicit.solver.kind == MidpointSolver::Kind::Shared) return;
  const Points& x = s.points().position;
  Points& step = s.implicit.residual;
  const double before = objective(s, x);
  for (int i = 0; i < kMostHalvings; ++i) {
    s.implicit.trial = x + step;
    if (objective(s, s.implicit.trial) <= before) return;
    step *= 0.5;
  }
}

/// The loads that this iteration's step asks for, and what they do to the step.
void solveContacts(const Substep& s) {
  ImplicitState& state = s.implicit;
  MidpointContacts& contacts = state.contacts;
  state.trial = s.points().position + state.residual;
  solveLoads(contacts, state.trial, state.start, s.time, s.h);
  contacts.load += contacts.change;
  state.trial.setZero();
  addLoads(contacts, contacts.change, state.trial);
  solve(state.solver, state.trial);
  state.residual += state.trial;
}

/// One iteration; returns the largest movement of a point (m). The step is found in place of the residual.
double iterate(const Substep& s, bool first) {
  ImplicitState& state = s.implicit;
  computeForces(s);
  update(state.solver, s.springs(), s.points().position);
  if (first || (s.touches() && state.solver.kind == MidpointSolver::Kind::Newton)) {
    const Points loads = state.contacts.load;
    prepare(state.contacts, s.body.contacts, state.solver);
    if (!first) state.contacts.load = loads;
  }
  computeResidual(s);
  solve(state.solver, state.residual);
  if (s.touches())
    solveContacts(s);
  else if (!s.springs().damped)
    shortenStep(s);
  s.points().position += state.residual;
  return state.residual.cwiseAbs().maxCoeff();
}

double longest(const SpringArrays& springs) {
  double length = 0.0;
  for (const double l : springs.restLength) length = std::max(length, l);
  return length;
}

/// Iterates to the end; returns the last movement (m).
double solveMidpoint(const Substep& s) {
  const bool shared = s.implicit.solver.kind == MidpointSolver::Kind::Shared;
  const int most = shared ? kMostSharedIterations : kMostNewtonIterations;
  const double enough = kConverged * longest(s.springs());
  double moved = 0.0;
  for (int i = 0; i < most; ++i) {
    moved = iterate(s, i == 0);
    if (moved <= enough) break;
  }
  return moved;
}

/// J of motion and springs.
double energy(const Substep& s) {
  return kineticEnergy(s.points()) + elasticEnergy(s.springs(), s.points().position);
}

/// J done on the points over the substep by the constant accelerations, by what holds points, and by
/// contacts.
double work(const Substep& s) {
  const PointState& p = s.points();
  double sum = 0.0;
  for (Eigen::Index i = 0; i < p.position.cols(); ++i) {
    const Eigen::Vector3d moved = p.position.col(i) - s.implicit.start.col(i);
    sum += isHeld(p, i) ? -p.force.col(i).dot(moved) : massOf(p, i) * p.acceleration.col(i).dot(moved);
  }
  for (Eigen::Index r = 0; r < s.implicit.contacts.load.cols(); ++r) {
    const auto point = (*s.body.contacts)[static_cast<std::size_t>(r)].point;
    sum += 4.0 / (s.h * s.h) *
           s.implicit.contacts.load.col(r).dot(p.position.col(point) - s.implicit.start.col(point));
  }
  return sum;
}

/// The state at the end of the substep from the midpoint.
void finish(const Substep& s) {
  PointState& p = s.points();
  p.position = 2.0 * p.position - s.implicit.start;
  for (Eigen::Index i = 0; i < p.position.cols(); ++i)
    if (!isHeld(p, i))
      p.velocity.col(i) =
          2.0 / s.h * (p.position.col(i) - s.implicit.start.col(i)) - s.implicit.startVelocity.col(i);
  if (s.touches()) settle(s.implicit.contacts, p, s.h);
}

/// m/s, root mean square: the midpoint rule is wrong by (omega h)^2 / 12 of the phase (compare
/// verletErrorRate), and what the iterations left.
double errorRate(const Substep& s, double left) {
  const PointState& p = s.points();
  Points& mean = s.implicit.meanAcceleration;
  s.implicit.trial = p.force.cwiseProduct(p.inverseMass);
  const double change = mean.size() ? (s.implicit.trial - mean).squaredNorm() : 0.0;
  mean = s.implicit.trial;
  return 2.0 * verletErrorRate(change, p.position.cols(), s.h) + left / s.h;
}

void advance(const Substep& s) {
  const double before = energy(s);
  start(s);
  const double left = solveMidpoint(s);
  computeForces(s);
  const double error = errorRate(s, left);
  finish(s);
  const double excess = energy(s) - before - work(s);
  if (excess > 0.0) removeKineticEnergy(s.points(), excess);
  s.body.errorRate = std::max(s.body.errorRate, error);
}

}  // namespace

bool canStepImplicitly(const SteppedBody& body) {
  if (body.springs->limited || (body.contacts && body.contacts->size() > kMostMidpointRows)) return false;
  const Points& w = body.points->inverseMass;
  return w.row(0) == w.row(1) && w.row(0) == w.row(2);
}

void stepImplicit(SteppedBody& body, ImplicitState& implicit, MidpointSolver::Kind kind, double tick,
                  int substeps, SharedFactors& factors) {
  const double h = tick / substeps;
  implicit.solver.kind = kind;
  prepare(implicit.solver, *body.springs, body.points->inverseMass, h, factors);
  implicit.residual.resizeLike(body.points->position);
  implicit.trial.resizeLike(body.points->position);
  body.errorRate = 0.0;
  for (int i = 0; i < substeps; ++i) advance({body, implicit, i * h, h});
}

}  // namespace limber
