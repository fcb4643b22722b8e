// SPDX-License-Identifier: Zlib
#pragma once

#include "command_list.h"

namespace limber::bench {

/// What a spring costs per substep, by instruction set and number type, and what contact rows add to it.
ExitCode runSprings(int argc, char** argv);

}  // namespace limber::bench
