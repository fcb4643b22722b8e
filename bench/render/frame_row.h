// SPDX-License-Identifier: Zlib
#pragma once

#include "render/frame_stage.h"

#include <string>
#include <vector>

namespace limber::bench {

/// What a case costs, drawn in one way.
struct FrameRow {
  std::string scene, path, context;
  int width = 0, height = 0;
  bool shadows = false;
  std::size_t bodies = 0;
  std::size_t points = 0, triangles = 0;  ///< of the whole picture: the floor has 4 and 2
  FrameTimes times;                       ///< medians
  std::size_t frames = 0;                 ///< that they are of
  std::size_t bytes = 0;                  ///< sent in a frame
  std::size_t bufferBytes = 0, drawCalls = 0;
  std::string driver;

  std::string size() const;
};

/// Columns of render.csv: times are milliseconds, see FrameTimes; mb_per_frame (positions, or vertices if
/// naive) and buffer_mb (all buffers that the path needs, without textures and render targets) in 10^6 bytes.
/// vertices counts the points that are written each frame, 8 a cube and 4 for the floor; triangles the
/// floor's 2, too. draw_calls are those of all passes, the background included.
std::vector<std::string> frameColumns();
std::vector<std::string> frameCells(const FrameRow& row);

/// The row of the same case and context with another path, or nullptr.
const FrameRow* findRow(const std::vector<FrameRow>& rows, const FrameRow& like, const std::string& path);

}  // namespace limber::bench
