// SPDX-License-Identifier: Zlib
#pragma once

#include "accuracy/accuracy_row.h"
#include "row_progress.h"

namespace limber::bench {

/// Plays the scene with all engines that can have it, at each tick. They take turns, a few ticks each, so
/// that all see the same machine. Where errors should shrink with the step, Limber is also given 2, 4 and 8
/// times the substeps that it needs to be stable.
std::vector<AccuracyRow> measureScene(const Scene& scene, const std::vector<double>& ticks,
                                      RowProgress& progress);

}  // namespace limber::bench
