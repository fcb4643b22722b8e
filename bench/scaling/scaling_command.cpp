// SPDX-License-Identifier: Zlib
#include "scaling/scaling_command.h"

#include "clocks.h"
#include "count_search.h"
#include "csv_table.h"
#include "output_folder.h"
#include "scaling/measure.h"
#include "scaling/scaling_csv.h"
#include "scaling/scaling_summary.h"

#include <algorithm>
#include <cstdio>
#include <fstream>

namespace limber::bench {
namespace {

// the counts of the paper's tables: measured to the end, real time or not
constexpr std::uint32_t kPaperCount = 64;

struct ModeSearch {
  Mode mode;
  CountSearch search;
  double secondsLeft;  // wall time

  bool isOver() const { return secondsLeft <= 0.0 || !search.next(); }
};

struct Bench {
  const ScalingOptions& options;
  CsvTable csv;
  RowProgress progress;
  std::vector<ScalingRow> rows;
};

std::vector<ModeSearch> startSearches(const ScalingOptions& options) {
  CountSearchSettings settings;
  settings.always = kPaperCount;
  settings.cap = options.maxBodies;
  const double secondsEach = 60.0 * options.minutes / static_cast<double>(options.modes.size());
  std::vector<ModeSearch> searches;
  for (const Mode mode : options.modes) searches.push_back({mode, CountSearch(settings), secondsEach});
  return searches;
}

void advance(ModeSearch& search, Bench& bench) {
  const Stopwatch watch;
  const std::uint32_t count = *search.search.next();
  const RowLimits limits{count > kPaperCount, search.secondsLeft};
  const ScalingRow row = measureRow(bench.options, search.mode, count, limits, bench.progress);
  bench.csv.add(scalingCells(row));
  bench.progress.finish(describe(row));
  bench.rows.push_back(row);
  search.search.report(row.realTime >= 1.0);
  search.secondsLeft -= watch.seconds();
}

void runAll(std::vector<ModeSearch>& searches, Bench& bench) {
  const auto over = [](const ModeSearch& search) { return search.isOver(); };
  while (!std::all_of(searches.begin(), searches.end(), over)) {
    for (ModeSearch& search : searches) {
      if (!search.isOver()) advance(search, bench);
    }
  }
}

std::vector<SearchEnd> endsOf(const std::vector<ModeSearch>& searches) {
  std::vector<SearchEnd> ends;
  for (const ModeSearch& s : searches) {
    const bool timeUp = s.search.next().has_value();
    ends.push_back({s.mode, s.search.largest(), !timeUp && !s.search.foundFailure(), timeUp});
  }
  return ends;
}

void publish(const std::string& summary, const std::string& folder) {
  std::ofstream(folder + "/scaling.txt") << summary;
  std::printf("%s", summary.c_str());
}

}  // namespace

ExitCode runScaling(int argc, char** argv) {
  const auto parsed = parseScalingOptions(argc, argv);
  if (const ExitCode* over = std::get_if<ExitCode>(&parsed)) return *over;
  const auto& options = std::get<ScalingOptions>(parsed);
  if (const std::string reason = prepareOutput(options.out, kScalingCsvName); !reason.empty()) {
    std::fprintf(stderr, "limber-bench: %s\n", reason.c_str());
    return kFailure;
  }
  Bench bench{options, CsvTable(options.out + "/" + kScalingCsvName, scalingColumns()), RowProgress(), {}};
  std::vector<ModeSearch> searches = startSearches(options);
  runAll(searches, bench);
  publish(summarise(options, bench.rows, endsOf(searches)), options.out);
  return kSuccess;
}

}  // namespace limber::bench
