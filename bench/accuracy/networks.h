// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/spring_network.h>

namespace limber::bench {

SharedNetwork pairNetwork();            ///< two points a metre apart along x, one spring
SharedNetwork chainNetwork(int links);  ///< a metre down from the origin, equal links; point 0 is the top
/// The same with a last point `ratio` times as heavy as each of the others.
SharedNetwork loadedChainNetwork(int links, double ratio);
SharedNetwork barNetwork(int links);  ///< a metre along x from the origin, equal links
SharedNetwork cubeNetwork();          ///< the unit cube about the origin, springs between all pairs: 28
SharedNetwork closedCubeNetwork();    ///< the same with a surface, for engines that collide faces
/// A box of points along x, y, z from the origin, with springs to all 26 neighbours.
SharedNetwork latticeNetwork(int nx, int ny, int nz, double spacing);
SharedNetwork clothNetwork(int side);  ///< a square metre of side x side points, all springs equal

}  // namespace limber::bench
