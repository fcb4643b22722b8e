// SPDX-License-Identifier: Zlib
#pragma once

#include "row_progress.h"

#include <string>
#include <vector>

namespace limber::bench {

/// What the demo's drop of 64 cubes costs the thread that simulates and draws it: 1920x1080, as the demo
/// draws it. Medians, milliseconds of wall time and of the thread's own.
struct PngRow {
  bool writes = false;  ///< each picture goes to a PngWriterThread
  double tickWall = 0.0, tickOwn = 0.0;
  double frameWall = 0.0, frameOwn = 0.0;  ///< tick, drawing, reading and handing over; waiting for the files
                                           ///< at the end of each block included
  std::size_t frames = 0;
};

struct PngLimits {
  int pairs = 10;  ///< of blocks
  int framesPerBlock = 10;
};

/// A row without and one with files, which take turns block by block of one drop. The files go into the
/// folder, which must exist, and are removed again.
std::vector<PngRow> measurePngCost(const std::string& folder, const PngLimits& limits, RowProgress& progress);

std::vector<std::string> pngColumns();
std::vector<std::string> pngCells(const PngRow& row);

}  // namespace limber::bench
