// SPDX-License-Identifier: Zlib
#pragma once

#include "command_list.h"

namespace limber::bench {

/// `limber-bench stability`: writes stability.csv and stability.txt.
ExitCode runStability(int argc, char** argv);

}  // namespace limber::bench
