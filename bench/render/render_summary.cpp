// SPDX-License-Identifier: Zlib
#include "render/render_summary.h"

#include "machine.h"
#include "text_format.h"

#include <map>
#include <thread>

namespace limber::bench {
namespace {

const char* const kConditions =
    "\nlimber: positions into the mapped buffer, a draw per shape. naive_points: uploaded and drawn\n"
    "body by body, normals by the shaders. naive: as the paper and Bullet's example browser do, three\n"
    "vertices of 36 bytes per triangle and normals made on the CPU, uploaded and drawn body by body.\n"
    "The paths take turns; medians, ms. Upload counts writing the positions, for all alike; own:\n"
    "upload and submit in the thread's own time, without waits for the rasteriser; process: the frame\n"
    "in the time of all threads, the rasteriser's included. Last column: the frame over limber's.\n";

bool sameCase(const FrameRow& a, const FrameRow& b) {
  return a.scene == b.scene && a.bodies == b.bodies && a.height == b.height && a.shadows == b.shadows;
}

std::string headingOf(const FrameRow& r) {
  return format("\n%zu %s, %zu triangles, %s, %s\n  %-7s %-13s %9s %9s %9s %9s %9s %9s %9s %8s %7s %7s %7s\n",
                r.bodies, r.scene.c_str(), r.triangles, r.size().c_str(),
                r.shadows ? "shadows" : "no shadows", "", "", "upload", "submit", "finish", "read", "frame",
                "own", "process", "MB/frame", "MB", "draws", "frame");
}

std::string lineOf(const FrameRow& r, const std::vector<FrameRow>& rows) {
  const FrameRow* limber = findRow(rows, r, "limber");
  const double ratio = limber ? r.times.frame / limber->times.frame : 0.0;
  return format("  %-7s %-13s %9.3f %9.3f %9.3f %9.3f %9.3f %9.3f %9.3f %8.3f %7.2f %7zu %7.2f\n",
                r.context.c_str(), r.path.c_str(), r.times.upload, r.times.submit, r.times.finish,
                r.times.read, r.times.frame, r.times.own, r.times.process,
                1e-6 * static_cast<double>(r.bytes), 1e-6 * static_cast<double>(r.bufferBytes), r.drawCalls,
                ratio);
}

std::string frameTables(const std::vector<FrameRow>& rows) {
  if (rows.empty()) return {};
  std::map<std::string, std::string> drivers;  // by context
  for (const FrameRow& row : rows) drivers[row.context] = row.driver;
  std::string text = kConditions;
  for (const auto& [context, driver] : drivers) text += context + ": " + driver + "\n";
  const FrameRow* last = nullptr;
  for (const FrameRow& row : rows) {
    if (!last || !sameCase(row, *last)) text += headingOf(row);
    last = &row;
    text += lineOf(row, rows);
  }
  return text;
}

std::string memoryTable(const std::vector<MemoryRow>& rows) {
  if (rows.empty()) return {};
  std::string text =
      "\nmemory, bytes a cube: of buffers, and resident in the process (with a software driver all of it)\n";
  for (const MemoryRow& row : rows) {
    const double bodies = static_cast<double>(row.bodies);
    const std::string resident =
        row.residentBytes ? format("%9.0f", *row.residentBytes / bodies) : "        -";
    text += format("  %-7s %-13s %6zu cubes %9.0f %s\n", row.context.c_str(), row.path.c_str(), row.bodies,
                   static_cast<double>(row.bufferBytes) / bodies, resident.c_str());
  }
  return text;
}

std::string pngTable(const std::vector<PngRow>& rows) {
  if (rows.empty()) return {};
  std::string text = format(
      "\n64 cubes dropped, 1920x1080, 4 samples a pixel, %u cores, which the driver's threads use, too;\n"
      "ms of wall and of the thread that simulates and draws\n  %-13s %10s %10s %10s %10s\n",
      std::thread::hardware_concurrency(), "", "tick wall", "own", "frame wall", "own");
  for (const PngRow& row : rows)
    text += format("  %-13s %10.3f %10.3f %10.3f %10.3f\n", row.writes ? "PNG files" : "no files",
                   row.tickWall, row.tickOwn, row.frameWall, row.frameOwn);
  return text;
}

std::string skinTable(const std::vector<SkinCostRow>& rows) {
  if (rows.empty()) return {};
  std::string text = format(
      "\nsmooth bodies on %zu points, 1280x720, no shadows: places by compute shader (gpu), by the renderer\n"
      "on the CPU (cpu), or by applySkin() and streamed; ms\n  %6s %8s %-7s %-8s %9s %9s %9s %9s %9s %9s\n",
      rows[0].points, "bodies", "vertices", "", "", "upload", "own", "frame", "process", "MB/frame", "MB");
  for (const SkinCostRow& row : rows)
    text += format("  %6zu %8zu %-7s %-8s %9.3f %9.3f %9.3f %9.3f %9.3f %9.2f\n", row.bodies, row.vertices,
                   row.weights.c_str(), row.way.c_str(), row.times.upload, row.times.own, row.times.frame,
                   row.times.process, 1e-6 * static_cast<double>(row.bytes),
                   1e-6 * static_cast<double>(row.bufferBytes));
  return text;
}

}  // namespace

std::string summariseRender(const RenderResults& results) {
  return describeMachine() + "\n" + frameTables(results.frames) + memoryTable(results.memory) +
         skinTable(results.skins) + pngTable(results.png);
}

}  // namespace limber::bench
