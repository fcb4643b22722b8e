// SPDX-License-Identifier: Zlib
#pragma once

#include "stability/hard_case.h"
#include "stability/stability_row.h"

#include <cstdio>

namespace limber::bench {

/// Plays the case with an engine at ticks of dt. With a `trace`, a line for each tick goes there: time,
/// energy over that at the start, drift of momentum, largest speed, height of the lowest point.
StabilityRow playCase(const HardCase& hard, const EngineChoice& choice, double dt,
                      std::FILE* trace = nullptr);

}  // namespace limber::bench
