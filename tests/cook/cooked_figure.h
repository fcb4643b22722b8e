// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/cook.h>

namespace limber::test {

/// Returns test_shapes::figure(), cooked with the default settings at the first call.
const CookedMesh& cookedFigure();

}  // namespace limber::test
