// SPDX-License-Identifier: Zlib
#pragma once

#include "stability/hard_case.h"
#include "stability/stability_row.h"

#include <cstdio>

namespace limber::bench {

/// Runs the case with an engine in ticks of dt. Writes a line per tick to `trace`, if given: time, energy
/// divided by that at the start, drift of momentum, largest speed, height of the lowest point.
StabilityRow playCase(const HardCase& hard, const EngineChoice& choice, double dt,
                      std::FILE* trace = nullptr);

}  // namespace limber::bench
