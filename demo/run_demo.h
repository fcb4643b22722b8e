// SPDX-License-Identifier: Zlib
#pragma once

#include "demo_options.h"

#include <csignal>

namespace limber::demo {

/// The signal that asks the run to stop, or 0. Set by a signal handler.
extern volatile std::sig_atomic_t stopSignal;

/// Thrown by a run that was asked to stop, so that nothing is left half written.
struct Stopped {};

/// Runs a scene to its end and reports. Exceptions: Stopped; std::runtime_error from the renderer and its
/// files.
ExitCode runDemo(const DemoOptions& options);

}  // namespace limber::demo
