// SPDX-License-Identifier: Zlib
#include "scaling/scaling_summary.h"

#include "machine.h"
#include "text_format.h"

#include <algorithm>
#include <map>

namespace limber::bench {
namespace {

const char* titleOf(Mode mode) {
  switch (mode) {
    case Mode::Bare:
      return "bare: as many loose Bullet spheres, no springs (Bullet's own share, with more contacts)";
    case Mode::None:
      return "none: soft cubes without a renderer";
    case Mode::Shaded:
      return "shaded: soft cubes with the shaded renderer (the paper's Table 1)";
    case Mode::Wireframe:
      return "wireframe: soft cubes with the wireframe renderer (the paper's Table 2)";
  }
  return "";
}

std::string header(Mode mode) {
  std::string line = format("%7s %9s %9s %9s %9s", "cubes", "tick ms", "max", "worst", "cpu ms");
  if (mode != Mode::Bare) line += format(" %9s", "own ms");
  if (isDrawn(mode)) line += format(" %10s %8s", "render ms", "GPU MB");
  return line + format(" %10s\n", "real time");
}

std::string lineOf(const ScalingRow& r) {
  std::string line =
      format("%7u %9.3f %9.3f %9.3f %9.3f", r.bodies, r.tickMean, r.tickMax, r.tickWorst, r.tickCpuMean);
  if (r.mode != Mode::Bare) line += format(" %9.3f", r.own.totalMs());
  if (isDrawn(r.mode)) line += format(" %10.2f %8.3f", r.renderMean, 1e-6 * static_cast<double>(r.gpuBytes));
  line += format(r.realTime < 100.0 ? " %8.2f x" : " %8.0f x", r.realTime);
  return line + (r.complete ? "\n" : format("  given up after %.1f s of simulation\n", r.simulatedSeconds));
}

std::string tableOf(Mode mode, const std::vector<ScalingRow>& rows) {
  std::string text = std::string("\n") + titleOf(mode) + "\n" + header(mode);
  for (const ScalingRow& row : rows) {
    if (row.mode == mode) text += lineOf(row);
  }
  return text;
}

std::string endOf(const SearchEnd& end) {
  const char* how = "";
  if (end.capReached) how = " or more (the largest count allowed)";
  if (end.timeUp) how = " or more (stopped by the time limit)";
  return format("  %-9s %6u cubes%s\n", nameOf(end.mode), end.largest, how);
}

std::string largestCounts(const std::vector<SearchEnd>& ends) {
  std::string text = "\nlargest number in real time\n";
  for (const SearchEnd& end : ends) text += endOf(end);
  return text +
         "  (the paper, on its author's machine: 64 cubes at 1.43 ms a tick, 128 no longer in real time)\n";
}

std::string driverOf(const std::vector<ScalingRow>& rows) {
  for (const ScalingRow& row : rows) {
    if (!row.driver.empty()) return "OpenGL: " + row.driver + "\n";
  }
  return {};
}

std::string conditions(const ScalingOptions& o) {
  std::string text;
  text += format(
      "tick 1/50 s, %g s of simulation, sampled every 0.1 s; worst is of all ticks, cpu of this thread;\n",
      o.seconds);
  text += format("frames of %d x %d;\n", o.width, o.height);
  text +=
      "real time counts a frame after each tick where there is a renderer (drawn and timed every fifth "
      "tick);\n";
  text += o.sleep ? "bodies at rest may fall asleep, and then cost next to nothing\n"
                  : "all bodies are kept awake: at rest they would fall asleep and cost next to nothing\n";
  return text;
}

/// Runs of the same cubes must end alike, whether drawn or not.
std::string hashWarnings(const std::vector<ScalingRow>& rows) {
  std::string text;
  std::map<std::uint32_t, std::uint64_t> hashes;
  for (const ScalingRow& row : rows) {
    if (!row.complete || row.mode == Mode::Bare) continue;
    const std::uint64_t expected = hashes.try_emplace(row.bodies, row.hash).first->second;
    if (row.hash == expected && row.repeatable) continue;
    text +=
        format("WARNING: runs of %u cubes (%s) do not end in the same state\n", row.bodies, nameOf(row.mode));
  }
  return text;
}

/// A tick computes on one thread and waits for nothing: wall time beyond processor time was taken by others.
std::string busyWarning(const std::vector<ScalingRow>& rows) {
  constexpr double kBusy = 1.1;
  double wall = 0.0, cpu = 0.0;
  for (const ScalingRow& row : rows) {
    wall += row.tickMean;
    cpu += row.tickCpuMean;
  }
  if (wall <= kBusy * cpu) return {};
  return format(
      "WARNING: the machine was busy: ticks took %.2f times their processor time, so all counts are too "
      "low\n",
      wall / cpu);
}

}  // namespace

std::string summarise(const ScalingOptions& options, std::vector<ScalingRow> rows,
                      const std::vector<SearchEnd>& ends) {
  std::stable_sort(rows.begin(), rows.end(),
                   [](const ScalingRow& a, const ScalingRow& b) { return a.bodies < b.bodies; });
  std::string text = describeMachine() + "\n" + driverOf(rows) + conditions(options);
  for (const Mode mode : options.modes) text += tableOf(mode, rows);
  if (!ends.empty()) text += largestCounts(ends);
  return text + hashWarnings(rows) + busyWarning(rows);
}

}  // namespace limber::bench
