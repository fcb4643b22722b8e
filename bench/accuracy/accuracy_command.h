// SPDX-License-Identifier: Zlib
#pragma once

#include "command_list.h"

namespace limber::bench {

/// Scenes whose outcome is known, played by Limber, btSoftBody and btDeformable: how far each is off, and
/// what a tick of it costs.
ExitCode runAccuracy(int argc, char** argv);

}  // namespace limber::bench
