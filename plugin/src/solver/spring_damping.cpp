// SPDX-License-Identifier: Zlib
#include "solver/spring_damping.h"

#include "solver/kernel_views.h"

namespace limber {
void prepareDampers(SpringArrays& springs, const Points& inverseMass, double dt) {
  if (!springs.damped || springs.damperTime == dt) return;
  springs.damperTime = dt;
  ++springs.revision;
  for (std::size_t i = 0; i < springs.size(); ++i) {
    const double w = inverseMass.col(springs.a[i]).maxCoeff() + inverseMass.col(springs.b[i]).maxCoeff();
    springs.dampHalf[i] = dampingImpulse(springs.damping[i], w, 0.5 * dt);
    springs.dampFull[i] = dampingImpulse(springs.damping[i], w, dt);
  }
}

void dampSprings(SpringArrays& springs, const std::vector<double>& impulse, SweepOrder order,
                 PointState& state) {
  if (!springs.damped) return;
  kernel::dampAll(kernelSprings(springs), impulse.data(), order == SweepOrder::Forward, kernelPoints(state));
}

}  // namespace limber
