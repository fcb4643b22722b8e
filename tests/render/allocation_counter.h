// SPDX-License-Identifier: Zlib
#pragma once

#include <cstddef>

namespace limber::render::test {

/// Returns the number of calls of operator new in this process so far.
std::size_t allocationCount();

}  // namespace limber::render::test
