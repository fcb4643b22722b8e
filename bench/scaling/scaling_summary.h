// SPDX-License-Identifier: Zlib
#pragma once

#include "scaling/scaling_options.h"

#include <string>
#include <vector>

namespace limber::bench {

/// Where the search of a mode ended.
struct SearchEnd {
  Mode mode = Mode::None;
  std::uint32_t largest = 0;  ///< cubes in real time; 0: not even one
  bool capReached = false;    ///< the largest count allowed is still in real time
  bool timeUp = false;        ///< the search was stopped before its end
};

/// All that was measured, as tables for people, with what they need to judge it.
std::string summarise(const ScalingOptions& options, std::vector<ScalingRow> rows,
                      const std::vector<SearchEnd>& ends);

}  // namespace limber::bench
