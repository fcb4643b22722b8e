// SPDX-License-Identifier: Zlib
#pragma once

#include "solver/point_state.h"
#include "solver/spring_arrays.h"
#include "solver/verlet_kernel.h"

namespace limber {

/// The force and direction of a spring whose ends are `d` apart (from a to b).
struct SpringPull {
  Eigen::Vector3d direction;  ///< unit vector, or 0 when the spring is slack or its ends coincide
  double force;               ///< N, above 0 pulls the ends together
};

/// Hooke's law with a constant for either side:  F = kE (|d| - L) if |d| > L, else kC (|d| - L).
/// A side without stiffness is slack. Coincident ends have no direction and so no force.
inline SpringPull springPull(const Eigen::Vector3d& d, double restLength, double extension,
                             double compression) {
  const kernel::Pull<double> pull = kernel::pullOf(d.squaredNorm(), restLength, extension, compression);
  return {d * pull.scale, pull.scale > 0.0 ? pull.force : 0.0};
}

struct SteppedBody;

/// Sets the points' forces to those of springs and volume, and keeps the springs' directions for the dampers.
void computeElasticForces(SteppedBody& body);

/// J in springs and volume, with the points at `position`.
double elasticEnergy(SteppedBody& body, const Points& position);

/// Sets `state.force` to the force of all springs and keeps their directions for the dampers.
void computeSpringForces(SpringArrays& springs, PointState& state);

/// J, of all springs at the present positions.
double elasticEnergy(const SpringArrays& springs, const Points& position);

}  // namespace limber
