// SPDX-License-Identifier: Zlib
#pragma once

#include "demo_options.h"
#include "run_figures.h"

#include <string>

namespace limber::demo {

/// Prints the figures of a run for people, on standard output.
void printTable(const DemoOptions& options, const RunFigures& figures);

/// Writes them to options.statsFile. Returns the reason when that fails, or an empty string.
std::string writeJson(const DemoOptions& options, const RunFigures& figures);

}  // namespace limber::demo
