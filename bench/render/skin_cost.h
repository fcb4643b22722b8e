// SPDX-License-Identifier: Zlib
#pragma once

#include "render/frame_stage.h"
#include "row_progress.h"

#include <string>
#include <vector>

namespace limber::bench {

/// A detailed body that rides on few points, 1280x720 without shadows: its places computed by the renderer's
/// compute shader or by applySkin() on the CPU and then streamed. Medians.
struct SkinCostRow {
  std::string weights;  ///< dense or sparse
  std::string way;      ///< gpu or cpu
  std::size_t vertices = 0, points = 0, weightCount = 0;
  FrameTimes times;       ///< upload counts applySkin()
  std::size_t bytes = 0;  ///< streamed a frame, the floor's included
  std::size_t bufferBytes = 0;
};

struct SkinLimits {
  std::uint32_t rings = 251, segments = 400;  ///< of the body: (rings - 1) x segments + 2 vertices
  int blocks = 5, framesPerBlock = 8;
};

/// A row for each kind of weights and way; the ways take turns.
std::vector<SkinCostRow> measureSkinCost(const DrawContext& context, const SkinLimits& limits,
                                         RowProgress& progress);

std::vector<std::string> skinColumns();
std::vector<std::string> skinCells(const SkinCostRow& row);

}  // namespace limber::bench
