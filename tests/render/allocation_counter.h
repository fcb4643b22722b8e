// SPDX-License-Identifier: Zlib
#pragma once

#include <cstddef>

namespace limber::render::test {

/// How often operator new was called in this process so far.
std::size_t allocationCount();

}  // namespace limber::render::test
