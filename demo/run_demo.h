// SPDX-License-Identifier: Zlib
#pragma once

#include "demo_options.h"

namespace limber::demo {

/// Runs a scene to its end and reports. Exceptions: std::runtime_error from the renderer and its files.
ExitCode runDemo(const DemoOptions& options);

}  // namespace limber::demo
