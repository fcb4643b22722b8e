// SPDX-License-Identifier: Zlib
#pragma once

#include "window/session.h"

#include <string>

namespace limber::demo {

/// Returns the command line that opens a window with the scene, settings, layers and camera of this one, and
/// behind it the tick, so that a screenshot tells how to get there.
std::string titleOf(const Session& session);

}  // namespace limber::demo
