// SPDX-License-Identifier: Zlib
#pragma once

#include "stability/stability_row.h"

namespace limber::bench {

/// Returns the printed summary: counts of each group and engine, and the targets that are met.
std::string summariseStability(const std::vector<StabilityRow>& rows);

}  // namespace limber::bench
