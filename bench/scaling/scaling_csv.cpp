// SPDX-License-Identifier: Zlib
#include "scaling/scaling_csv.h"

#include "csv_table.h"

namespace limber::bench {
namespace {

using Row = ScalingRow;

struct Column {
  const char* name;
  std::string (*cell)(const Row&);
};

std::string softCell(const Row& r, double value) { return r.mode == Mode::Bare ? "" : numberCell(value); }
std::string drawnCell(const Row& r, double value) { return isDrawn(r.mode) ? numberCell(value) : ""; }

const Column kColumns[] = {
    {"bodies", [](const Row& r) { return countCell(r.bodies); }},
    {"points", [](const Row& r) { return countCell(r.points); }},
    {"springs", [](const Row& r) { return countCell(r.springs); }},
    {"mode", [](const Row& r) { return std::string(nameOf(r.mode)); }},
    {"tick_ms_mean", [](const Row& r) { return numberCell(r.tickMean); }},
    {"tick_ms_max", [](const Row& r) { return numberCell(r.tickMax); }},
    {"render_ms_mean", [](const Row& r) { return drawnCell(r, r.renderMean); }},
    {"gpu_mb", [](const Row& r) { return drawnCell(r, 1e-6 * static_cast<double>(r.gpuBytes)); }},
    {"realtime", [](const Row& r) { return numberCell(r.realTime); }},
    {"tick_ms_median", [](const Row& r) { return numberCell(r.tickMedian); }},
    {"tick_ms_worst", [](const Row& r) { return numberCell(r.tickWorst); }},
    {"tick_cpu_ms_mean", [](const Row& r) { return numberCell(r.tickCpuMean); }},
    {"us_per_point", [](const Row& r) { return numberCell(microsecondsPerPoint(r)); }},
    {"own_ms_mean", [](const Row& r) { return softCell(r, r.own.totalMs()); }},
    {"gather_ms", [](const Row& r) { return softCell(r, r.own.beforeStepMs()); }},
    {"springs_ms", [](const Row& r) { return softCell(r, r.own.stepMs); }},
    {"hand_over_ms", [](const Row& r) { return softCell(r, r.own.writeMs); }},
    {"take_back_ms", [](const Row& r) { return softCell(r, r.own.readBackMs); }},
    {"render_ms_max", [](const Row& r) { return drawnCell(r, r.renderMax); }},
    {"contacts", [](const Row& r) { return numberCell(r.contacts); }},
    {"asleep_share", [](const Row& r) { return numberCell(r.asleepShare); }},
    {"simulated_s", [](const Row& r) { return numberCell(r.simulatedSeconds); }},
    {"complete", [](const Row& r) { return countCell(r.complete); }},
    {"repeats", [](const Row& r) { return countCell(static_cast<std::uint64_t>(r.repeats)); }},
    {"repeatable", [](const Row& r) { return countCell(r.repeatable); }},
    {"hash", [](const Row& r) { return hexCell(r.hash); }},
};

}  // namespace

std::vector<std::string> scalingColumns() {
  std::vector<std::string> names;
  for (const Column& column : kColumns) names.push_back(column.name);
  return names;
}

std::vector<std::string> scalingCells(const ScalingRow& row) {
  std::vector<std::string> cells;
  for (const Column& column : kColumns) cells.push_back(column.cell(row));
  return cells;
}

}  // namespace limber::bench
