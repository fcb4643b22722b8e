// SPDX-License-Identifier: Zlib
#include "solver/spring_forces.h"

#include "solver/elastic_limit.h"
#include "solver/kernel_views.h"
#include "solver/verlet_step.h"

#include <cmath>

namespace limber {

void computeSpringForces(SpringArrays& springs, PointState& state) {
  if (springs.limited) {
    state.force.setZero();
    addLimitedForces(springs, state);
  } else {
    kernel::computeForces(kernelSprings(springs), kernelPoints(state));
  }
}

void computeElasticForces(SteppedBody& body) {
  computeSpringForces(*body.springs, *body.points);
  if (body.volumes) addVolumeForces(*body.volumes, *body.points);
  if (body.tetrahedra) addTetrahedronForces(*body.tetrahedra, *body.points);
}

double elasticEnergy(SteppedBody& body, const Points& position) {
  return elasticEnergy(*body.springs, position) +
         (body.volumes ? volumeEnergy(*body.volumes, position) : 0.0) +
         (body.tetrahedra ? tetrahedronEnergy(*body.tetrahedra, position) : 0.0);
}

double elasticEnergy(const SpringArrays& springs, const Points& position) {
  double energy = 0.0;
  for (std::size_t i = 0; i < springs.size(); ++i) {
    const double length = (position.col(springs.b[i]) - position.col(springs.a[i])).norm();
    const double stretch = length - springs.restLength[i];
    const double stiffness = stretch > 0.0 ? springs.extensionStiffness[i] : springs.compressionStiffness[i];
    energy +=
        springs.limit.stiffenStrain > 0.0
            ? stiffenedEnergy(stiffness, stretch, springs.limit.stiffenStrain * springs.originalLength[i],
                              springs.limit.stiffenFactor)
            : 0.5 * stiffness * stretch * stretch;
  }
  return energy;
}

}  // namespace limber
