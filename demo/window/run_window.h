// SPDX-License-Identifier: Zlib
#pragma once

#include "demo_options.h"
#include "window/recording.h"

namespace limber::demo {

/// Opens the window and returns when the user closes it. Throws Stopped, and std::runtime_error from the
/// window, the renderer and files.
ExitCode runWindow(const DemoOptions& options);

/// Replays a recording without a window, prints the state's hash and compares it.
ExitCode runReplay(const DemoOptions& options);

/// Creates the session of the options, or of the recording if there is one. Prints the notes of the scene.
/// Throws std::runtime_error with the reason if the scene cannot be made.
std::unique_ptr<Session> createSession(const DemoOptions& options, const Recording* recording);

/// Performs the commands that the options ask for: layers, camera and settings.
void performOptions(Session& session, const DemoOptions& options);

}  // namespace limber::demo
