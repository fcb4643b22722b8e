// SPDX-License-Identifier: Zlib
#pragma once

#include "scaling/scaling_row.h"

#include <string>
#include <vector>

namespace limber::bench {

constexpr const char* kScalingCsvName = "scaling.csv";

std::vector<std::string> scalingColumns();
/// In the order of the columns; what a mode does not have is an empty cell.
std::vector<std::string> scalingCells(const ScalingRow& row);

}  // namespace limber::bench
