// SPDX-License-Identifier: Zlib
#pragma once

#include "engines/engine.h"

namespace limber::bench {

constexpr double kCubeRadius = 0.02;  // m, of its points

/// Returns a closed unit cube of 1 kg that stands on y = 0, slightly damped.
BodySetup restingCube(double stiffness);

double topOf(const Eigen::Matrix3Xd& cube);  ///< m, mean height of its upper four points

/// Returns the height (m) of the cube's top at rest under a load (N), by statics alone. Its lower points can
/// slide on the floor but not leave it.
double restHeight(const BodySetup& cube, double load);

}  // namespace limber::bench
