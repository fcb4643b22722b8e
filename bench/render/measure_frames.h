// SPDX-License-Identifier: Zlib
#pragma once

#include "render/frame_row.h"
#include "row_progress.h"

namespace limber::bench {

struct FrameLimits {
  int blocks = 5;
  int framesPerBlock = 6;  ///< the first of each block, after another path's, is not counted
};

/// A row for each context and path. All are open at once and take turns block by block, in an order that
/// rotates, over the same poses.
std::vector<FrameRow> measureFrames(const FrameCase& frameCase, const std::vector<DrawContext>& contexts,
                                    const FrameLimits& limits, RowProgress& progress);

/// One line for people: "4096 cubes, 1920x1080, shadows".
std::string describe(const FrameCase& frameCase);

}  // namespace limber::bench
