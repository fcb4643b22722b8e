// SPDX-License-Identifier: Zlib
#pragma once

#include "engines/engine.h"

#include <optional>

namespace limber::bench {

/// Returns Limber with its default, with Collision::Points, and within budgets of substeps; btSoftBody with
/// 1, 4 (the reference) and 10 iterations; btDeformable; loose spheres.
///
/// btSoftBody's flags are the cheapest ones without loss, as measured by --set flags=yes (4 iterations, times
/// relative to SDF_RS | VF_SS, depth in the pile as a share of a body's size):
///
///                   512 cubes at rest   cloth   dense body   pile of 200, and how deep
///   SDF_RS                0.97          0.81       0.97       0.20   50 %: nothing holds them apart
///   SDF_RS | VF_SS        1             1          1          1      47 %
///   SDF_RS | CL_SS        1.9           0.82       0.98       4.4    42 %
///   CL_RS | CL_SS         3.7           0.67       1.06       4.5    23 %
///
/// SDF_RS is used where bodies do not touch each other, and SDF_RS | VF_SS in the pile. With CL_RS the cloth
/// is cheaper, but slips off the ball.
std::vector<EngineChoice> contactEngines();

/// Bytes of Limber's bodies in a world after some ticks of free flight, with Bullet's objects for the points
/// and the overhead of the allocator, without the network, which bodies share.
struct MemoryUse {
  double perPoint = 0.0, perSpring = 0.0, perBody = 0.0;
  double networkPerSpring = 0.0;  ///< of a network, which all bodies of one shape share
};

/// Measures bodies that differ only in points or springs. Empty if the C library cannot report it (not
/// glibc).
std::optional<MemoryUse> measureMemory(bool quick);

}  // namespace limber::bench
