// SPDX-License-Identifier: Zlib
#pragma once

#include "networks/network_row.h"
#include "support/network_shapes.h"

namespace limber::bench {

/// A way to place braces, and what measuring it takes.
struct ReturnQuestion {
  network_shapes::NamedShape shape;
  std::string rule;           ///< none, equal, two-ring, pipeline, or random: as many as pipeline's, anywhere
  std::uint32_t runs = 100;   ///< of all five kinds together
  std::uint64_t seed = 1000;  ///< of the deformations that are measured, none that Pipeline has tried
};

const std::vector<std::string>& braceRules();

/// Throws std::runtime_error with the reason if the shape cannot be cooked. `as` is the row of the pipeline,
/// which random follows; else unused.
NetworkRow measureReturns(const ReturnQuestion& question, const NetworkRow* as);

}  // namespace limber::bench
