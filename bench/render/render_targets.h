// SPDX-License-Identifier: Zlib
#pragma once

#include "render/render_results.h"

namespace limber::bench {

/// A line for each target: hit, MISS, or "-" where it was not measured. Of several rows the worst one counts.
std::string renderTargets(const RenderResults& results);

}  // namespace limber::bench
