// SPDX-License-Identifier: Zlib
#pragma once

#include "demo_options.h"

#include <csignal>

namespace limber::demo {

/// The signal that stops the run, or 0. A signal handler sets it.
extern volatile std::sig_atomic_t stopSignal;

/// Thrown after a stop signal, so that no file stays incomplete.
struct Stopped {};

/// Runs a scene to its end and writes the report. Throws Stopped, and std::runtime_error from the renderer
/// and its files.
ExitCode runDemo(const DemoOptions& options);

}  // namespace limber::demo
