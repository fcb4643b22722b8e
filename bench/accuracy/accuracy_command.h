// SPDX-License-Identifier: Zlib
#pragma once

#include "command_list.h"

namespace limber::bench {

/// Plays scenes with a known outcome in Limber, btSoftBody and btDeformable, and reports the error of each
/// engine and the time of its ticks.
ExitCode runAccuracy(int argc, char** argv);

}  // namespace limber::bench
