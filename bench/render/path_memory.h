// SPDX-License-Identifier: Zlib
#pragma once

#include "render/frame_stage.h"

#include <optional>
#include <string>
#include <vector>

namespace limber::bench {

/// What bodies cost the process when they are drawn in one way.
struct MemoryRow {
  std::string path, context;
  std::size_t bodies = 0;
  std::size_t bufferBytes = 0;  ///< of the renderer's buffers, see FrameStage::bufferBytes()
  /// What a process that has drawn one cube grows by when it draws so many: staging, and with a software
  /// driver its buffers, objects and lists of commands. Each row has a process of its own. Empty where the
  /// system does not tell (no /proc).
  std::optional<double> residentBytes;
};

/// To be called before this process has made any context or thread: it forks. A row for each path and
/// context.
std::vector<MemoryRow> measurePathMemory(std::size_t bodies, const std::vector<DrawContext>& contexts);

std::vector<std::string> memoryColumns();
std::vector<std::string> memoryCells(const MemoryRow& row);

}  // namespace limber::bench
