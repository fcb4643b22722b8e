// SPDX-License-Identifier: Zlib
#pragma once

#include <string>

namespace limber::bench {

/// The machine and the build in one line: figures mean nothing without them.
std::string describeMachine();

/// Returns the most memory that the process has held so far, MB of 2^20 bytes.
double peakMegabytes();

}  // namespace limber::bench
