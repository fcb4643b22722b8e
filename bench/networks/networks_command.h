// SPDX-License-Identifier: Zlib
#pragma once

#include "command_list.h"

namespace limber::bench {

/// Do bodies keep their shape? Tables of networks, bracing rules, masses, skins and materials.
ExitCode runNetworks(int argc, char** argv);

}  // namespace limber::bench
