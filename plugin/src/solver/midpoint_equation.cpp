// SPDX-License-Identifier: Zlib
#include "solver/midpoint_equation.h"

#include "solver/midpoint_damping.h"
#include "solver/springs.h"

#include <cmath>

namespace limber {
namespace {

/// y of implicit_step.h; held points go with their velocity.
Eigen::Vector3d inertialMidpoint(const Substep& s, Eigen::Index i) {
  return s.implicit.start.col(i) + 0.5 * s.h * s.implicit.startVelocity.col(i) +
         0.25 * s.h * s.h * s.points().acceleration.col(i);
}

/// 0 to 1, see midpoint_damping.h; backward Euler takes the mean velocity.
double damperLookAhead(const Substep& s, std::size_t i) {
  if (s.euler) return 0.0;
  return lookAhead(s.springs().damping[i], inverseMassesOf(s.springs(), s.points().inverseMass, i), s.h);
}

/// m: by how much farther apart the ends of spring i are, along its damper, than where the damper would pull
/// with no force. With the velocity v_m + beta (v_m - v0) of midpoint_damping.h and v_m = 2/h (x - x0) that
/// is where   (1 + beta) (x - x0) = beta h/2 v0.
double damperStretch(const Substep& s, std::size_t i, const Points& x) {
  const ImplicitState& state = s.implicit;
  const auto a = s.springs().a[i], b = s.springs().b[i];
  const double beta = damperLookAhead(s, i), old = 0.5 * s.h * beta / (1.0 + beta);
  const auto way = [&](std::uint32_t j) -> Eigen::Vector3d {
    return x.col(j) - state.start.col(j) - old * state.startVelocity.col(j);
  };
  return state.damperDirection.col(static_cast<Eigen::Index>(i)).dot(way(b) - way(a));
}

/// kg: h/2 c (1 + beta).
double damperWeight(const Substep& s, std::size_t i) {
  return 0.5 * s.h * s.springs().damping[i] * (1.0 + damperLookAhead(s, i));
}

/// Adds the dampers' forces for the velocities that the present midpoint positions mean.
void addDampingForces(const Substep& s) {
  const SpringArrays& springs = s.springs();
  if (!springs.damped) return;
  Points& force = s.points().force;
  for (std::size_t i = 0; i < springs.size(); ++i) {
    const double pull = 4.0 / (s.h * s.h) * damperWeight(s, i) * damperStretch(s, i, s.points().position);
    const Eigen::Vector3d f = pull * s.implicit.damperDirection.col(static_cast<Eigen::Index>(i));
    force.col(springs.a[i]) += f;
    force.col(springs.b[i]) -= f;
  }
}

}  // namespace

void computeForces(const Substep& s, bool turnDampers) {
  computeElasticForces(s.body);
  if (turnDampers) s.implicit.damperDirection = s.springs().direction;
  addDampingForces(s);
}

void computeResidual(const Substep& s) {
  const PointState& p = s.points();
  Points& r = s.implicit.residual;
  for (Eigen::Index i = 0; i < p.position.cols(); ++i) {
    if (isHeld(p.inverseMass, i))
      r.col(i).setZero();
    else
      r.col(i) = massOf(p.inverseMass, i) * (inertialMidpoint(s, i) - p.position.col(i)) +
                 0.25 * s.h * s.h * p.force.col(i);
  }
  if (s.touches()) addLoads(s.implicit.contacts, s.implicit.contacts.load, r);
}

double objective(const Substep& s, const Points& position) {
  const PointState& p = s.points();
  double sum = 0.25 * s.h * s.h * elasticEnergy(s.body, position);
  for (Eigen::Index i = 0; i < position.cols(); ++i)
    if (!isHeld(p.inverseMass, i))
      sum += 0.5 * massOf(p.inverseMass, i) * (position.col(i) - inertialMidpoint(s, i)).squaredNorm();
  for (std::size_t i = 0; s.springs().damped && i < s.springs().size(); ++i)
    sum += 0.5 * damperWeight(s, i) * std::pow(damperStretch(s, i, position), 2);
  return sum;
}

}  // namespace limber
