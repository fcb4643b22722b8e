// SPDX-License-Identifier: Zlib
#pragma once

#include "render/frame_row.h"
#include "render/path_memory.h"
#include "render/png_cost.h"
#include "render/skin_cost.h"

namespace limber::bench {

/// All of a run; parts that were not asked for are empty.
struct RenderResults {
  std::vector<FrameRow> frames;
  std::vector<MemoryRow> memory;
  std::vector<PngRow> png;
  std::vector<SkinCostRow> skins;
};

}  // namespace limber::bench
