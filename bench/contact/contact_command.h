// SPDX-License-Identifier: Zlib
#pragma once

#include "command_list.h"

namespace limber::bench {

/// Measures the cost of bodies that fly, land, rest, sleep, drape and pile up, compared to btSoftBody,
/// btDeformable and as many separate spheres.
ExitCode runContact(int argc, char** argv);

}  // namespace limber::bench
