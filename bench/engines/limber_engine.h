// SPDX-License-Identifier: Zlib
#pragma once

#include "engines/engine.h"

namespace limber::bench {

/// Changes what a scene asks for before Limber's body is made, as to force a stepper.
using TuneSettings = std::function<void(SoftBodySettings&)>;

std::unique_ptr<Engine> makeLimberEngine(TuneSettings tune = {});

/// Forces a stepper.
std::unique_ptr<Engine> makeLimberEngine(Stepper stepper);

/// How many of Verlet's substeps the body takes in a tick of dt when it is not asked for more.
int stableSubsteps(const BodySetup& setup, double dt);

}  // namespace limber::bench
