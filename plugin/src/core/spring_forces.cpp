// SPDX-License-Identifier: Zlib
#include "core/spring_forces.h"

#include <cmath>

namespace limber {

void addSpringForces(SpringArrays& springs, PointState& state) {
  for (std::size_t i = 0; i < springs.size(); ++i) {
    const Eigen::Vector3d d = state.position.col(springs.b[i]) - state.position.col(springs.a[i]);
    const SpringPull pull =
        springPull(d, springs.restLength[i], springs.extensionStiffness[i], springs.compressionStiffness[i]);
    springs.direction.col(static_cast<Eigen::Index>(i)) = pull.direction;
    const Eigen::Vector3d force = pull.force * pull.direction;
    state.force.col(springs.a[i]) += force;
    state.force.col(springs.b[i]) -= force;
  }
}

double elasticEnergy(const SpringArrays& springs, const Points& position) {
  double energy = 0.0;
  for (std::size_t i = 0; i < springs.size(); ++i) {
    const double length = (position.col(springs.b[i]) - position.col(springs.a[i])).norm();
    const double stretch = length - springs.restLength[i];
    energy += 0.5 * stretch * stretch *
              (stretch > 0.0 ? springs.extensionStiffness[i] : springs.compressionStiffness[i]);
  }
  return energy;
}

}  // namespace limber
