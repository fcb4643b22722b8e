// SPDX-License-Identifier: Zlib
#pragma once

#include "render/render_results.h"

namespace limber::bench {

/// All that was measured, as tables for people.
std::string summariseRender(const RenderResults& results);

}  // namespace limber::bench
