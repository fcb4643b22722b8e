// SPDX-License-Identifier: Zlib
// What do several threads gain? Each scene runs once without a parallel function, once with one that measures
// the parallel parts on one thread, and once on each number of threads, all in turns.
#include "command_list.h"

#include "clocks.h"
#include "command_line.h"
#include "contact/contact_stage.h"
#include "csv_table.h"
#include "engines/limber_engine.h"
#include "machine.h"
#include "row_progress.h"
#include "sample_stats.h"
#include "text_format.h"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <cstdio>
#include <deque>
#include <thread>

namespace limber::bench {
namespace {

constexpr const char* kCsvName = "threads.csv";

/// Numbers of threads for which the gain is foretold by the share outside the parallel parts.
constexpr unsigned kForetold[] = {8, 64};

/// Runs tasks in order and adds up their time.
struct TimedInOrder {
  double milliseconds = 0.0;

  ParallelFor function() {
    return [this](std::size_t count, const std::function<void(std::size_t)>& task) {
      const Stopwatch watch;
      for (std::size_t i = 0; i < count; ++i) task(i);
      milliseconds += watch.time().wallMs;
    };
  }
};

/// What a scene costs on one number of threads.
struct Cost {
  unsigned threads = 1;
  double tick = 0.0, noise = 0.0;  ///< ms
};

struct SceneCost {
  std::string scene;
  std::vector<Cost> costs;  ///< the first is that of one thread, without a parallel function
  double outside = 0.0;     ///< share of the tick outside the parallel parts, on one thread

  double gain(const Cost& cost) const { return costs.front().tick / cost.tick; }
  /// Returns the gain of so many threads if the parallel parts cost nothing but their work (Amdahl 1967).
  double foretold(unsigned threads) const { return 1.0 / (outside + (1.0 - outside) / threads); }
};

std::vector<unsigned> threadCounts() {
  const unsigned most = std::max(2u, std::thread::hardware_concurrency());
  std::vector<unsigned> counts;
  for (unsigned n = 2; n < most; n *= 2) counts.push_back(n);
  counts.push_back(most);
  return counts;
}

ContactEngine engineWith(const std::string& name, ParallelFor parallelFor) {
  return {name, [parallelFor](const ContactScene&) { return makeLimberEngine(parallelFor); }};
}

/// Returns the share of the ticks' time that was spent outside the tasks.
double shareOutside(const ContactStage& stage, double inside) {
  return std::clamp(1.0 - inside / std::max(sum(stage.wallTicks()), 1e-9), 0.0, 1.0);
}

SceneCost measureScene(const ContactScene& scene, RowProgress& progress) {
  SceneCost result;
  result.scene = scene.name;
  TimedInOrder timed;
  std::deque<ThreadPool> pools;
  std::deque<ContactStage> stages;
  stages.emplace_back(scene, engineWith("one thread", nullptr));
  stages.emplace_back(scene, engineWith("timed", timed.function()));
  result.costs.push_back({1});
  for (const unsigned threads : threadCounts()) {
    pools.emplace_back(threads);
    stages.emplace_back(scene, engineWith("threads", pools.back().parallelFor()));
    result.costs.push_back({threads});
  }
  const int ticks = scene.settleTicks + scene.measuredTicks;
  double settled = 0.0;
  // threads of other stages sleep while one runs
  for (int done = 0; done < ticks;) {
    const bool settles = done < scene.settleTicks;
    const int turn = std::min(scene.turn, (settles ? scene.settleTicks : ticks) - done);
    for (ContactStage& stage : stages) stage.advance(turn, 1e9);
    done += turn;
    if (settles) settled = timed.milliseconds;
    progress.show(scene.name, static_cast<double>(done) / ticks);
  }
  result.outside = shareOutside(stages[1], timed.milliseconds - settled);
  for (std::size_t i = 0; i < result.costs.size(); ++i) {
    const std::vector<double>& times = stages[i == 0 ? 0 : i + 1].wallTicks();
    result.costs[i].tick = median(times);
    result.costs[i].noise = halfMiddle(times);
  }
  return result;
}

/// The median of the repeats, for each number.
SceneCost medianOf(const std::vector<SceneCost>& repeats) {
  const auto middle = [&](auto number) {
    std::vector<double> all;
    for (const SceneCost& r : repeats) all.push_back(number(r));
    return median(all);
  };
  SceneCost result = repeats.front();
  result.outside = middle([](const SceneCost& r) { return r.outside; });
  for (std::size_t i = 0; i < result.costs.size(); ++i) {
    result.costs[i].tick = middle([&](const SceneCost& r) { return r.costs[i].tick; });
    result.costs[i].noise = middle([&](const SceneCost& r) { return r.costs[i].noise; });
  }
  return result;
}

std::string describe(const SceneCost& s) {
  std::string text = format("%-28s %8.2f", s.scene.c_str(), s.costs.front().tick);
  for (std::size_t i = 1; i < s.costs.size(); ++i) text += format(" %8.2f", s.gain(s.costs[i]));
  text += format(" %8.0f %%", 100.0 * s.outside);
  for (const unsigned threads : kForetold) text += format(" %8.1f", s.foretold(threads));
  return text;
}

std::string summary(const std::vector<SceneCost>& scenes) {
  std::string text = describeMachine() + "\nms of wall time a tick on one thread; gain of threads\n";
  text += format("%-28s %8s", "", "ms");
  for (const unsigned threads : threadCounts())
    text += format(" %8s", ("x" + std::to_string(threads)).c_str());
  text += format(" %10s", "outside");
  for (const unsigned threads : kForetold) text += format(" %8s", ("to x" + std::to_string(threads)).c_str());
  text += "\n";
  for (const SceneCost& scene : scenes) text += describe(scene) + "\n";
  return text +
         "outside: share of the tick outside the parallel parts; to xN: most that N threads could gain\n";
}

void addRows(CsvTable& csv, const SceneCost& s) {
  for (const Cost& cost : s.costs)
    csv.add({s.scene, countCell(cost.threads), numberCell(cost.tick), numberCell(cost.noise),
             numberCell(s.gain(cost)), numberCell(s.outside), numberCell(s.foretold(cost.threads))});
}

/// Returns the scenes with awake bodies whose names contain `text`.
std::vector<ContactScene> scenesNamed(const std::string& text, bool quick) {
  std::vector<ContactScene> chosen;
  std::vector<ContactScene> all = allContactScenes(quick);
  for (ContactScene& scene : all)
    if (scene.role != Role::Asleep && scene.name.find(text) != std::string::npos)
      chosen.push_back(std::move(scene));
  return chosen;
}

}  // namespace

ExitCode runThreads(int argc, char** argv) {
  CLI::App app("What do several threads gain?", "limber-bench threads");
  std::string out = "out/bench", only;
  bool quick = false;
  int repeats = 3;
  app.add_option("--out", out, "folder of threads.csv and threads.txt (default out/bench)");
  app.add_option("--scene", only, "only scenes whose name has this in it");
  app.add_option("--repeats", repeats, "repeats of each scene (default 3)")->check(CLI::PositiveNumber);
  app.add_flag("--quick", quick, "few bodies, seconds in all: the times mean nothing");
  if (const auto end = parse(app, argc, argv)) return *end;
  const std::vector<ContactScene> chosen = scenesNamed(only, quick);
  if (chosen.empty()) {
    std::fprintf(stderr, "limber-bench threads: no scene has '%s' in its name\n", only.c_str());
    return kUsage;
  }
  if (!canWrite(out, kCsvName)) return kFailure;
  CsvTable csv(out + "/" + kCsvName,
               {"scene", "threads", "tick_ms", "tick_noise_ms", "gain", "share_outside", "gain_at_most"});
  RowProgress progress;
  std::vector<SceneCost> scenes;
  for (const ContactScene& scene : chosen) {
    std::vector<SceneCost> measured;
    for (int i = 0; i < repeats; ++i) measured.push_back(measureScene(scene, progress));
    scenes.push_back(medianOf(measured));
    addRows(csv, scenes.back());
    progress.finish(describe(scenes.back()));
  }
  publish(summary(scenes), out + "/threads.txt");
  return kSuccess;
}

}  // namespace limber::bench
