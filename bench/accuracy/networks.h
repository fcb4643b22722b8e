// SPDX-License-Identifier: Zlib
#pragma once

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

}  // namespace limber::bench
