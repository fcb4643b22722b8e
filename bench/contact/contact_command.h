// SPDX-License-Identifier: Zlib
#pragma once

#include "command_list.h"

namespace limber::bench {

/// What bodies cost that fly, land, rest, sleep, drape and lie in a heap, beside btSoftBody, btDeformable and
/// as many loose spheres.
ExitCode runContact(int argc, char** argv);

}  // namespace limber::bench
