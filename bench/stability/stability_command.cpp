// SPDX-License-Identifier: Zlib
#include "command_list.h"

#include "command_line.h"
#include "csv_table.h"
#include "row_progress.h"
#include "stability/play_case.h"
#include "stability/stability_summary.h"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace limber::bench {
namespace {

constexpr const char* kCsvName = "stability.csv";

struct Options {
  std::string out = "out/bench";
  bool quick = false, trace = false, list = false;
  std::string name, engine;  ///< substrings of the names to be run; empty: all
  unsigned seed = 0;         ///< 0: all
  double rate = 0.0;         ///< ticks per second, 0: both
};

void addOptions(CLI::App& app, Options& options) {
  app.add_option("--out", options.out, "folder of stability.csv and stability.txt (default out/bench)");
  app.add_flag("--quick", options.quick, "fewer cases, seeds and minutes");
  app.add_option("--case", options.name, "only cases whose name has this in it");
  app.add_option("--engine", options.engine, "only engines with this in 'engine setting'");
  app.add_option("--seed", options.seed, "only this seed");
  app.add_option("--rate", options.rate, "only so many ticks a second, 30 or 60")->check(CLI::PositiveNumber);
  app.add_flag("--trace", options.trace,
               "print for each tick: time, energy over that at the start, drift of momentum, largest speed, "
               "lowest height");
  app.add_flag("--cases", options.list, "list the cases, play none");
}

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

std::vector<HardCase> casesOf(const Options& options) {
  std::vector<HardCase> cases;
  for (HardCase& hard : allHardCases(options.quick))
    if (contains(hard.name, options.name) && (options.seed == 0 || hard.seed == options.seed))
      cases.push_back(std::move(hard));
  return cases;
}

/// Returns Limber with each stepper, and those settings of other engines that are most similar to the springs
/// and most stable.
std::vector<EngineChoice> enginesOf(const Options& options) {
  const char* const others[] = {"btSoftBody 4 it kLST from k", "btSoftBody 10 it kLST 1",
                                "btDeformable implicit"};
  std::vector<EngineChoice> engines;
  for (EngineChoice& choice : allEngines()) {
    const std::string full = choice.engine + " " + choice.setting;
    const bool wanted = choice.engine == "limber" ||
                        std::find(std::begin(others), std::end(others), full) != std::end(others);
    if (wanted && contains(full, options.engine)) engines.push_back(std::move(choice));
  }
  return engines;
}

std::vector<double> ticksOf(const Options& options) {
  if (options.rate > 0.0) return {1.0 / options.rate};
  return {1.0 / 30, 1.0 / 60};
}

std::string fullName(const HardCase& hard) { return hard.name + " seed " + std::to_string(hard.seed); }

std::vector<StabilityRow> runAll(const Options& options) {
  CsvTable csv(options.out + "/" + kCsvName, stabilityColumns());
  RowProgress progress;
  std::vector<StabilityRow> rows;
  const std::vector<HardCase> cases = casesOf(options);
  for (std::size_t i = 0; i < cases.size(); ++i) {
    for (const double dt : ticksOf(options))
      for (const EngineChoice& engine : enginesOf(options)) {
        progress.show(fullName(cases[i]), static_cast<double>(i) / static_cast<double>(cases.size()));
        rows.push_back(playCase(cases[i], engine, dt, options.trace ? stdout : nullptr));
        csv.add(stabilityCells(rows.back()));
      }
    progress.finish(fullName(cases[i]));
  }
  return rows;
}

}  // namespace

ExitCode runStability(int argc, char** argv) {
  CLI::App app("What do soft bodies survive?", "limber-bench stability");
  Options options;
  addOptions(app, options);
  if (const auto end = parse(app, argc, argv)) return *end;
  if (options.list) {
    for (const HardCase& hard : casesOf(options)) std::printf("%s\n", fullName(hard).c_str());
    return kSuccess;
  }
  if (!canWrite(options.out, kCsvName)) return kFailure;
  const std::string summary = summariseStability(runAll(options));
  publish(summary, options.out + "/stability.txt");
  return kSuccess;
}

}  // namespace limber::bench
