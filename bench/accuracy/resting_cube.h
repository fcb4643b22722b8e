// SPDX-License-Identifier: Zlib
#pragma once

#include "engines/engine.h"

namespace limber::bench {

constexpr double kCubeRadius = 0.02;  // m, of its points

/// A closed unit cube of 1 kg that stands on y = 0, damped a little.
BodySetup restingCube(double stiffness);

double topOf(const Eigen::Matrix3Xd& cube);  ///< m, mean height of its upper four points

/// Where its top comes to rest, with a load of so many newtons on it: its lower points can slide on the floor
/// but not leave it, by statics alone.
double restHeight(const BodySetup& cube, double load);

}  // namespace limber::bench
