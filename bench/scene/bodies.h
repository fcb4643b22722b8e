// SPDX-License-Identifier: Zlib
#pragma once

// The bodies of the benches: their networks and settings.

#include "engines/engine.h"

#include <limber/spring_network.h>

namespace limber::bench {

SharedNetwork pairNetwork();            ///< two points 1 m apart along x, one spring
SharedNetwork chainNetwork(int links);  ///< 1 m down from the origin, equal links; point 0 is the top
/// Returns a chain whose last point has `ratio` times the mass of each of the others.
SharedNetwork loadedChainNetwork(int links, double ratio);
SharedNetwork barNetwork(int links);  ///< 1 m along x from the origin, equal links
SharedNetwork cubeNetwork();          ///< the unit cube about the origin, springs between all 28 pairs
SharedNetwork closedCubeNetwork();    ///< cubeNetwork() with a surface, for engines that collide faces
/// Returns a box of points along x, y, z from the origin, with springs to all 26 neighbours.
SharedNetwork latticeNetwork(int nx, int ny, int nz, double spacing);
SharedNetwork clothNetwork(int side);  ///< a square metre of side x side points, all springs equal

/// Returns a set-up of a body with these properties; both stiffnesses are `stiffness`.
BodySetup bodyOf(SharedNetwork network, double mass, double stiffness, double damping = 0.0);

// --- a cube at rest --------------------------------------------------------------------------------

constexpr double kCubeRadius = 0.02;  // m, of its points

/// Returns a closed unit cube of 1 kg that stands on y = 0, slightly damped.
BodySetup restingCube(double stiffness);

double topOf(const Eigen::Matrix3Xd& cube);  ///< m, mean height of its upper four points

/// Returns the height (m) of the cube's top at rest under a load (N), by statics alone. Its lower points can
/// slide on the floor but not leave it.
double restHeight(const BodySetup& cube, double load);

}  // namespace limber::bench
