// SPDX-License-Identifier: Zlib
#include "render/render_targets.h"

#include "text_format.h"

#include <algorithm>
#include <functional>
#include <optional>
#include <thread>

namespace limber::bench {
namespace {

using Rows = std::vector<FrameRow>;
using Value = std::optional<double>;

std::string line(const std::string& what, const Value& value, bool hit, const char* unit = "") {
  if (!value) return format("  -     %-84s not measured\n", what.c_str());
  return format("  %-4s  %-84s %.3g%s\n", hit ? "hit" : "MISS", what.c_str(), *value, unit);
}

std::string atLeast(const std::string& what, const Value& value, double least) {
  return line(what, value, value && *value >= least);
}

std::string atMost(const std::string& what, const Value& value, double most, const char* unit = "") {
  return line(what, value, value && *value <= most, unit);
}

/// The smallest ratio of the naive path to ours among the rows that are chosen.
Value leastRatio(const Rows& rows, const std::function<bool(const FrameRow&)>& chosen,
                 const std::function<double(const FrameRow&)>& cost) {
  Value least;
  for (const FrameRow& row : rows) {
    const FrameRow* naive = findRow(rows, row, "naive");
    if (row.path != "limber" || !naive || !chosen(row)) continue;
    const double ratio = cost(*naive) / cost(row);
    least = std::min(least.value_or(ratio), ratio);
  }
  return least;
}

double frameOf(const FrameRow& row) { return row.times.frame; }

double processOf(const FrameRow& row) { return row.times.process; }

double uploadAndSubmit(const FrameRow& row) { return row.times.upload + row.times.submit; }

double ownOf(const FrameRow& row) { return row.times.own; }

/// Without shadows: with them a software driver waits in it for the shadow map, which costs all paths the
/// same.
std::string submissionLines(const Rows& rows, std::size_t bodies) {
  const auto line = [&](bool shadows, const char* what, const std::function<double(const FrameRow&)>& cost) {
    const auto chosen = [&](const FrameRow& r) { return r.bodies == bodies && r.shadows == shadows; };
    return atLeast(format("%zu cubes, %s of naive at least 10 times ours", bodies, what),
                   leastRatio(rows, chosen, cost), 10.0);
  };
  return line(false, "no shadows: upload + submit", uploadAndSubmit) +
         line(true, "shadows: upload + submit, own time,", ownOf);
}

std::string frameLines(const Rows& rows, bool shadows) {
  const auto chosen = [shadows](const FrameRow& r) {
    return r.bodies == 4096 && r.height == 1080 && r.shadows == shadows;
  };
  const auto line = [&](const char* clock, const std::function<double(const FrameRow&)>& cost) {
    return atLeast(format("4096 cubes, 1920x1080, %s: frame of naive at least 2 times ours, %s",
                          shadows ? "shadows" : "no shadows", clock),
                   leastRatio(rows, chosen, cost), 2.0);
  };
  return line("wall", frameOf) + line("all threads", processOf);
}

/// No target, but where a single body may lose.
std::string ballLine(const Rows& rows) {
  const auto isBall = [](const FrameRow& r) { return r.scene == "ball"; };
  return atLeast("(no target) one large smooth body: frame of naive over ours at least 1, all threads",
                 leastRatio(rows, isBall, processOf), 1.0);
}

std::string byteLines(const Rows& rows) {
  Value most, naive;
  for (const FrameRow& row : rows) {
    const double bytes = static_cast<double>(row.bytes);
    if (row.path == "limber" && row.scene == "cubes")
      most = std::max(most.value_or(0.0), bytes / static_cast<double>(row.points));
    if (row.path == "naive" && row.scene == "cubes")
      naive = bytes * 12.0 / static_cast<double>(row.triangles);  // 12 triangles a cube
  }
  return atMost("bytes sent for a point of a cube and frame: at most 12", most, 12.0) +
         line("bytes sent for a cube by naive: over 1000", naive, naive && *naive > 1000.0);
}

Value memoryRatio(const std::vector<MemoryRow>& rows, const std::function<Value(const MemoryRow&)>& bytes) {
  Value most;
  for (const MemoryRow& ours : rows) {
    for (const MemoryRow& naive : rows) {
      if (ours.path != "limber" || naive.path != "naive" || ours.context != naive.context) continue;
      const Value a = bytes(ours), b = bytes(naive);
      if (a && b) most = std::max(most.value_or(0.0), *a / *b);
    }
  }
  return most;
}

std::string memoryLines(const std::vector<MemoryRow>& rows) {
  const std::size_t bodies = rows.empty() ? 4096 : rows.front().bodies;
  const auto what = [bodies](const char* text) { return format("%zu cubes: %s", bodies, text); };
  return atMost(what("buffers at most 0.1 of naive's"),
                memoryRatio(rows, [](const MemoryRow& r) { return Value(double(r.bufferBytes)); }), 0.1) +
         atMost(what("resident memory at most 0.1 of naive's"),
                memoryRatio(rows, [](const MemoryRow& r) { return r.residentBytes; }), 0.1);
}

std::string pngLines(const std::vector<PngRow>& rows) {
  const auto slowdown = [&rows](double PngRow::*time) {
    return rows.size() < 2 ? Value() : Value(100.0 * (rows[1].*time / rows[0].*time - 1.0));
  };
  const unsigned cores = std::thread::hardware_concurrency();
  const auto what = [cores](const char* text) {
    return format("1080p as PNG: %s at most 10 %% slower (%u cores)", text, cores);
  };
  return atMost(what("tick, the thread's own time,"), slowdown(&PngRow::tickOwn), 10.0, " %") +
         atMost(what("tick, wall time,"), slowdown(&PngRow::tickWall), 10.0, " %") +
         atMost(what("tick and drawing, own time,"), slowdown(&PngRow::frameOwn), 10.0, " %") +
         atMost(what("tick and drawing, wall time,"), slowdown(&PngRow::frameWall), 10.0, " %");
}

}  // namespace

std::string renderTargets(const RenderResults& results) {
  return "\ntargets; of several sizes, contexts and shadows the worst\n" +
         submissionLines(results.frames, 1024) + submissionLines(results.frames, 4096) +
         frameLines(results.frames, false) + frameLines(results.frames, true) + ballLine(results.frames) +
         byteLines(results.frames) + memoryLines(results.memory) + pngLines(results.png);
}

}  // namespace limber::bench
