// SPDX-License-Identifier: Zlib
#pragma once

#include "row_progress.h"
#include "scaling/scaling_options.h"

namespace limber::bench {

/// When a run is given up.
struct RowLimits {
  bool mayGiveUp = false;      ///< as soon as it is clear that real time is lost
  double wallSeconds = 600.0;  ///< in any case after so long
};

/// A new scene of `count` cubes, run for the time asked for; the middle one of several runs where they are
/// short.
ScalingRow measureRow(const ScalingOptions& options, Mode mode, std::uint32_t count, const RowLimits& limits,
                      RowProgress& progress);

}  // namespace limber::bench
