// SPDX-License-Identifier: Zlib
#pragma once

#include "stability/stability_row.h"

namespace limber::bench {

/// What is printed: counts of each group and engine, and which targets are hit.
std::string summariseStability(const std::vector<StabilityRow>& rows);

}  // namespace limber::bench
