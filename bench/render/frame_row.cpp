// SPDX-License-Identifier: Zlib
#include "render/frame_row.h"

#include "csv_table.h"
#include "text_format.h"

namespace limber::bench {

std::string FrameRow::size() const { return format("%dx%d", width, height); }

std::vector<std::string> frameColumns() {
  return {"bodies",       "vertices",        "size",      "path",       "context",
          "upload_ms",    "submit_ms",       "finish_ms", "read_ms",    "frame_ms",
          "mb_per_frame", "shadows",         "buffer_mb", "draw_calls", "scene",
          "triangles",    "bytes_per_frame", "frames",    "own_ms",     "process_ms"};
}

std::vector<std::string> frameCells(const FrameRow& row) {
  constexpr double kMega = 1e-6;
  return {countCell(row.bodies),
          countCell(row.points),
          row.size(),
          row.path,
          row.context,
          numberCell(row.times.upload),
          numberCell(row.times.submit),
          numberCell(row.times.finish),
          numberCell(row.times.read),
          numberCell(row.times.frame),
          numberCell(kMega * static_cast<double>(row.bytes)),
          row.shadows ? "1" : "0",
          numberCell(kMega * static_cast<double>(row.bufferBytes)),
          countCell(row.drawCalls),
          row.scene,
          countCell(row.triangles),
          countCell(row.bytes),
          countCell(row.frames),
          numberCell(row.times.own),
          numberCell(row.times.process)};
}

const FrameRow* findRow(const std::vector<FrameRow>& rows, const FrameRow& like, const std::string& path) {
  for (const FrameRow& row : rows)
    if (row.path == path && row.scene == like.scene && row.context == like.context &&
        row.bodies == like.bodies && row.height == like.height && row.shadows == like.shadows)
      return &row;
  return nullptr;
}

}  // namespace limber::bench
