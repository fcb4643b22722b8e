// SPDX-License-Identifier: Zlib
#pragma once

#include "engines/engine.h"

#include <limber/parallel.h>

namespace limber::bench {

/// Changes a scene's settings before Limber's body is made, for example to force a stepper.
using TuneSettings = std::function<void(SoftBodySettings&)>;

std::unique_ptr<Engine> makeLimberEngine(TuneSettings tune = {});

/// Returns an engine whose soft bodies are stepped by this function; see SoftBodySystem::setParallelFor().
std::unique_ptr<Engine> makeLimberEngine(ParallelFor parallelFor);

/// Forces a stepper.
std::unique_ptr<Engine> makeLimberEngine(Stepper stepper);

/// Returns the number of Verlet substeps that the body takes in a tick of dt seconds with its own settings.
int stableSubsteps(const BodySetup& setup, double dt);

}  // namespace limber::bench
