// SPDX-License-Identifier: Zlib
#pragma once

#include "render/frame_stage.h"
#include "row_progress.h"

#include <string>
#include <vector>

namespace limber::bench {

/// Detailed bodies that follow few points, 1280x720 without shadows. Their places are computed by the
/// renderer's compute shader (gpu), by the renderer on the CPU (cpu), or by the program with applySkin(),
/// which then streams them (streamed). Medians.
struct SkinCostRow {
  std::string weights;  ///< dense or sparse
  std::string way;      ///< gpu, cpu or streamed
  std::size_t bodies = 0;
  std::size_t vertices = 0, points = 0, weightCount = 0;
  FrameTimes times;       ///< upload counts the computation on the CPU
  std::size_t bytes = 0;  ///< streamed a frame, the floor's and the normals of the CPU included
  std::size_t bufferBytes = 0;
};

/// Bodies of (rings - 1) x segments + 2 vertices each.
struct SkinnedBodies {
  std::size_t count;
  std::uint32_t rings, segments;
};

struct SkinLimits {
  std::vector<SkinnedBodies> cases{{1, 251, 400}, {9, 141, 250}};
  int blocks = 5, framesPerBlock = 4;
};

/// A row for each case, kind of weights and way; the ways take turns.
std::vector<SkinCostRow> measureSkinCost(const DrawContext& context, const SkinLimits& limits,
                                         RowProgress& progress);

std::vector<std::string> skinColumns();
std::vector<std::string> skinCells(const SkinCostRow& row);

}  // namespace limber::bench
