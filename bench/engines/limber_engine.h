// SPDX-License-Identifier: Zlib
#pragma once

#include "engines/engine.h"

namespace limber::bench {

/// Changes what a scene asks for before Limber's body is made, as to force a stepper.
using TuneSettings = std::function<void(SoftBodySettings&)>;

std::unique_ptr<Engine> makeLimberEngine(TuneSettings tune = {});

/// Forces a stepper.
std::unique_ptr<Engine> makeLimberEngine(Stepper stepper);

}  // namespace limber::bench
