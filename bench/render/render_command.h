// SPDX-License-Identifier: Zlib
#pragma once

#include "command_list.h"

namespace limber::bench {

/// What drawing many bodies costs, beside the way of the paper and of Bullet's example browser.
ExitCode runRender(int argc, char** argv);

}  // namespace limber::bench
