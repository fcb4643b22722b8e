// SPDX-License-Identifier: Zlib
#pragma once

#include <string>

namespace limber::bench {

/// The machine and the build in one line: figures mean nothing without them.
std::string describeMachine();

}  // namespace limber::bench
