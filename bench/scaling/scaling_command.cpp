// SPDX-License-Identifier: Zlib
#include "command_list.h"

#include "clocks.h"
#include "command_line.h"
#include "count_search.h"
#include "csv_table.h"
#include "scaling/measure.h"
#include "scaling/scaling_csv.h"
#include "scaling/scaling_summary.h"

#include <algorithm>
#include <cstddef>
#include <cstdio>

namespace limber::bench {
namespace {

// the counts of the paper's tables: measured to the end, real time or not
constexpr std::uint32_t kPaperCount = 64;

struct ModeSearch {
  Mode mode;
  CountSearch search;

  bool isOver() const { return !search.next(); }
};

struct Bench {
  const ScalingOptions& options;
  CsvTable csv;
  RowProgress progress;
  std::vector<ScalingRow> rows;
  Stopwatch watch;

  double secondsLeft() const { return 60.0 * options.minutes - watch.seconds(); }
};

std::vector<ModeSearch> startSearches(const ScalingOptions& options) {
  CountSearchSettings settings;
  settings.always = kPaperCount;
  settings.cap = options.maxBodies;
  std::vector<ModeSearch> searches;
  for (const Mode mode : options.modes) searches.push_back({mode, CountSearch(settings)});
  return searches;
}

ScalingRow measureAndKeep(Mode mode, std::uint32_t count, const RowLimits& limits, Bench& bench) {
  ScalingRow row = measureRow(bench.options, mode, count, limits, bench.progress);
  bench.csv.add(scalingCells(row));
  bench.progress.finish(describe(row));
  bench.rows.push_back(row);
  return row;
}

void advance(ModeSearch& search, double seconds, Bench& bench) {
  const std::uint32_t count = *search.search.next();
  const RowLimits limits{count > kPaperCount, seconds};
  const ScalingRow row = measureAndKeep(search.mode, count, limits, bench);
  search.search.report(row.realTime >= 1.0);
}

std::ptrdiff_t countUnfinished(const std::vector<ModeSearch>& searches) {
  return std::count_if(searches.begin(), searches.end(), [](const ModeSearch& s) { return !s.isOver(); });
}

/// No row may take more than its mode's share of the time that is left.
void searchAll(std::vector<ModeSearch>& searches, Bench& bench) {
  while (countUnfinished(searches) > 0 && bench.secondsLeft() > 0.0) {
    for (ModeSearch& search : searches) {
      if (search.isOver()) continue;
      const double share = bench.secondsLeft() / static_cast<double>(countUnfinished(searches));
      if (share > 0.0) advance(search, share, bench);
    }
  }
}

void measureCounts(Bench& bench) {
  for (const std::uint32_t count : bench.options.counts) {
    for (const Mode mode : bench.options.modes) measureAndKeep(mode, count, RowLimits(), bench);
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

}  // namespace

ExitCode runScaling(int argc, char** argv) {
  const auto parsed = parseScalingOptions(argc, argv);
  if (const ExitCode* over = std::get_if<ExitCode>(&parsed)) return *over;
  const auto& options = std::get<ScalingOptions>(parsed);
  if (!canWrite(options.out, kScalingCsvName)) return kFailure;
  Bench bench{
      options, CsvTable(options.out + "/" + kScalingCsvName, scalingColumns()), RowProgress(), {}, {}};
  std::vector<ModeSearch> searches;
  if (options.counts.empty()) {
    searches = startSearches(options);
    searchAll(searches, bench);
  } else {
    measureCounts(bench);
  }
  publish(summarise(options, bench.rows, endsOf(searches)), options.out + "/scaling.txt");
  return kSuccess;
}

}  // namespace limber::bench
