// SPDX-License-Identifier: Zlib
#pragma once

#include "accuracy/accuracy_row.h"
#include "row_progress.h"

namespace limber::bench {

/// Plays the scene with all engines that support it, at each length of ticks. The engines take turns of a few
/// ticks, so that the load of the machine is the same for all. In ordered scenes Limber is also run with 2, 4
/// and 8 times the substeps that it needs to be stable.
std::vector<AccuracyRow> measureScene(const Scene& scene, const std::vector<double>& ticks,
                                      RowProgress& progress);

}  // namespace limber::bench
