// SPDX-License-Identifier: Zlib
#include "core/spring_damping.h"

namespace limber {
namespace {

void dampSpring(const SpringArrays& springs, std::size_t i, double impulsePerSpeed, PointState& state) {
  const auto a = springs.a[i], b = springs.b[i];
  const Eigen::Vector3d n = springs.direction.col(static_cast<Eigen::Index>(i));
  const double speed = n.dot(state.velocity.col(b) - state.velocity.col(a));
  const Eigen::Vector3d impulse = (impulsePerSpeed * speed) * n;
  state.velocity.col(a) += impulse.cwiseProduct(state.inverseMass.col(a));
  state.velocity.col(b) -= impulse.cwiseProduct(state.inverseMass.col(b));
}

}  // namespace

void prepareDampers(SpringArrays& springs, const Points& inverseMass, double dt) {
  if (!springs.damped) return;
  for (std::size_t i = 0; i < springs.size(); ++i) {
    const double w = inverseMass.col(springs.a[i]).maxCoeff() + inverseMass.col(springs.b[i]).maxCoeff();
    springs.dampHalf[i] = dampingImpulse(springs.damping[i], w, 0.5 * dt);
    springs.dampFull[i] = dampingImpulse(springs.damping[i], w, dt);
  }
}

void dampSprings(const SpringArrays& springs, const std::vector<double>& impulse, SweepOrder order,
                 PointState& state) {
  if (!springs.damped) return;
  const std::size_t count = springs.size();
  if (order == SweepOrder::Forward)
    for (std::size_t i = 0; i < count; ++i) dampSpring(springs, i, impulse[i], state);
  else
    for (std::size_t i = count; i-- > 0;) dampSpring(springs, i, impulse[i], state);
}

}  // namespace limber
