// SPDX-License-Identifier: Zlib
#include "solver/elastic_limit.h"

#include "solver/spring_forces.h"

#include <algorithm>
#include <cmath>

namespace limber {
namespace {

void breakSpring(SpringArrays& springs, std::size_t i) {
  springs.extensionStiffness[i] = springs.compressionStiffness[i] = springs.damping[i] = 0.0;
  springs.dampHalf[i] = springs.dampFull[i] = 0.0;
  ++springs.broken;
}

bool isBroken(const SpringArrays& springs, std::size_t i) {
  return springs.extensionStiffness[i] == 0.0 && springs.compressionStiffness[i] == 0.0;
}

/// The new rest length once the elongation at `length` is beyond the yield strain.
double yieldedLength(const SpringArrays& springs, std::size_t i, double length) {
  const double original = springs.originalLength[i], rest = springs.restLength[i];
  const double largest = springs.limit.yieldStrain * original, elongation = length - rest;
  if (std::abs(elongation) <= largest) return rest;
  const double wanted = length - std::copysign(largest, elongation);
  const double change = springs.limit.yieldMaximum * original;
  return std::clamp(wanted, original - change, original + change);
}

void updateLimits(SpringArrays& springs, std::size_t i, double length) {
  const ElasticLimit& limit = springs.limit;
  if (isBroken(springs, i)) return;
  if (limit.breakStrain > 0.0 && length > (1.0 + limit.breakStrain) * springs.originalLength[i])
    breakSpring(springs, i);
  else if (limit.yieldStrain > 0.0)
    springs.restLength[i] = yieldedLength(springs, i, length);
}

}  // namespace

double stiffenedEnergy(double k, double e, double s, double factor) {
  const double beyond = std::max(0.0, std::abs(e) - s), below = std::abs(e) - beyond;
  return 0.5 * k * below * below + beyond * (k * s + 0.5 * k * factor * beyond);
}

void addLimitedForces(SpringArrays& springs, PointState& state) {
  const ElasticLimit& limit = springs.limit;
  for (std::size_t i = 0; i < springs.size(); ++i) {
    const Eigen::Vector3d d = state.position.col(springs.b[i]) - state.position.col(springs.a[i]);
    if (springs.originalLength[i] > 0.0) updateLimits(springs, i, d.norm());
    SpringPull pull =
        springPull(d, springs.restLength[i], springs.extensionStiffness[i], springs.compressionStiffness[i]);
    if (limit.stiffenStrain > 0.0 && pull.force != 0.0) {
      const double e = d.norm() - springs.restLength[i];
      const double beyond = std::abs(e) - limit.stiffenStrain * springs.originalLength[i];
      if (beyond > 0.0) pull.force += pull.force / e * std::copysign((limit.stiffenFactor - 1.0) * beyond, e);
    }
    springs.direction.col(static_cast<Eigen::Index>(i)) = pull.direction;
    const Eigen::Vector3d force = pull.force * pull.direction;
    state.force.col(springs.a[i]) += force;
    state.force.col(springs.b[i]) -= force;
  }
}

}  // namespace limber
