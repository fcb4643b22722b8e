// SPDX-License-Identifier: Zlib
#pragma once

#include "solver/point_state.h"

#include <cstdint>

namespace limber {

// Sums over the points that are not held (inverse mass above 0), in SI units.
double totalMass(const PointState& state);
Eigen::Vector3d centerOfMass(const PointState& state);
Eigen::Vector3d linearMomentum(const PointState& state);
Eigen::Vector3d angularMomentum(const PointState& state);  ///< about the origin
double kineticEnergy(const PointState& state);

/// FNV-1a over the bits of positions and velocities.
std::uint64_t stateHash(const PointState& state);

}  // namespace limber
