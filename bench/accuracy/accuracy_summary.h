// SPDX-License-Identifier: Zlib
#pragma once

#include "accuracy/accuracy_row.h"

namespace limber::bench {

/// Returns a report for people: the best result of each engine in each scene, orders of convergence, and
/// targets with hit or MISS.
std::string summariseAccuracy(const std::vector<Scene>& scenes, const std::vector<AccuracyRow>& rows);

}  // namespace limber::bench
