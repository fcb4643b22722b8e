// SPDX-License-Identifier: Zlib
#pragma once

#include "command_list.h"

namespace limber::bench {

/// Repeats Tables 1 and 2 of C. Hart's paper: cubes fall onto a floor, 1, 2, 4 ... of them until 50 ticks a
/// second are too many, then bisecting; with loose spheres beside them. The modes take turns, count by count,
/// so that all see the same machine.
ExitCode runScaling(int argc, char** argv);

}  // namespace limber::bench
