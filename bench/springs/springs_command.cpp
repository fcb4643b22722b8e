// SPDX-License-Identifier: Zlib
#include "command_list.h"

#include "clocks.h"
#include "command_line.h"
#include "csv_table.h"
#include "sample_stats.h"
#include "springs/test_cubes.h"
#include "text_format.h"

#include <CLI/CLI.hpp>

#include <cstdio>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace limber::bench {
namespace {

constexpr const char* kCsvName = "springs.csv";
constexpr double kTick = 1.0 / 60;
constexpr int kSubsteps = 20;

/// One way of stepping cubes; `springs` are stepped by each run().
struct Way {
  std::string what;
  bool damped = false, resting = false;
  double springs = 0.0;
  std::function<void()> run;
  std::vector<double> ns;  ///< per spring and substep, one for each repeat
};

Way way(const std::string& what, double damping, bool resting, int bodies) {
  Way w;
  w.what = what;
  w.damped = damping > 0.0;
  w.resting = resting;
  w.springs = 28.0 * bodies;
  return w;
}

void addSingles(double damping, bool resting, std::vector<Way>& ways) {
  for (const bool four : {false, true}) {
    if (four && !canStepSpringBatches()) continue;
    auto cubes = std::make_shared<std::deque<TestCube>>(makeCubes(1, damping, resting));
    if (four) cubes->front().group.bodies[0].springBatches = &cubes->front().springBatches;
    ways.push_back(way(four ? "1 body AVX2" : "1 body scalar", damping, resting, 1));
    ways.back().run = [cubes] { stepVerlet(cubes->front().group, kTick, kSubsteps); };
  }
}

void addLanes(double damping, bool resting, std::vector<Way>& ways) {
  for (const InstructionSet set : {InstructionSet::Sse2, InstructionSet::Avx2, InstructionSet::Avx512}) {
    if (!isAvailable(set)) continue;
    auto cubes = std::make_shared<std::deque<TestCube>>(makeCubes(laneCount(set), damping, resting));
    auto scratch = std::make_shared<LaneScratch>();
    ways.push_back(way(std::string("lanes ") + nameOf(set), damping, resting, laneCount(set)));
    ways.back().run = [cubes, scratch, set] {
      std::vector<SolverBody*> bodies;
      for (TestCube& cube : *cubes) bodies.push_back(&cube.group.bodies[0]);
      stepLanes(bodies.data(), bodies.size(), *scratch, kTick, kSubsteps, set);
    };
  }
}

std::vector<Way> allWays() {
  std::vector<Way> ways;
  for (const bool resting : {false, true})
    for (const double damping : {0.0, 1.0}) {
      addSingles(damping, resting, ways);
      addLanes(damping, resting, ways);
    }
  return ways;
}

/// All ways in turn, so that what else the machine does strikes them alike.
void measure(std::vector<Way>& ways, int repeats) {
  constexpr int kRuns = 100;
  for (int repeat = 0; repeat < repeats; ++repeat)
    for (Way& w : ways) {
      w.run();
      const Stopwatch watch;
      for (int i = 0; i < kRuns; ++i) w.run();
      w.ns.push_back(1e6 * watch.time().cpuMs / (kRuns * kSubsteps * w.springs));
    }
}

const Way* withoutContacts(const Way& resting, const std::vector<Way>& ways) {
  for (const Way& w : ways)
    if (!w.resting && w.what == resting.what && w.damped == resting.damped) return &w;
  return nullptr;
}

std::string summary(const std::vector<Way>& ways) {
  std::string text =
      "ns per spring and substep, cubes of 8 points and 28 springs (median, half the middle half)\n";
  text += format("%-16s %-9s %8s %8s\n", "stepped", "", "ns", "+-");
  for (const Way& w : ways) {
    if (w.resting) continue;
    text += format("%-16s %-9s %8.2f %8.2f\n", w.what.c_str(), w.damped ? "damped" : "undamped", median(w.ns),
                   halfMiddle(w.ns));
  }
  text += "\nfour contact rows with friction of a cube at rest, beside its springs\n";
  for (const Way& w : ways) {
    const Way* bare = w.resting ? withoutContacts(w, ways) : nullptr;
    if (!bare) continue;
    text += format("%-16s %-9s %+5.0f %%\n", w.what.c_str(), w.damped ? "damped" : "undamped",
                   100.0 * (median(w.ns) / median(bare->ns) - 1.0));
  }
  return text;
}

void writeCsv(const std::string& file, const std::vector<Way>& ways) {
  CsvTable csv(file, {"stepped", "damped", "contacts", "ns_per_spring_substep", "ns_noise"});
  for (const Way& w : ways)
    csv.add({w.what, w.damped ? "1" : "0", w.resting ? "4" : "0", numberCell(median(w.ns)),
             numberCell(halfMiddle(w.ns))});
}

}  // namespace

ExitCode runSprings(int argc, char** argv) {
  CLI::App app("What does a spring cost per substep?", "limber-bench springs");
  std::string out = "out/bench";
  bool quick = false;
  app.add_option("--out", out, "folder of springs.csv and springs.txt (default out/bench)");
  app.add_flag("--quick", quick, "5 repeats instead of 41");
  if (const auto end = parse(app, argc, argv)) return *end;
  if (!canWrite(out, kCsvName)) return kFailure;
  std::vector<Way> ways = allWays();
  measure(ways, quick ? 5 : 41);
  writeCsv(out + "/" + kCsvName, ways);
  publish(summary(ways), out + "/springs.txt");
  return kSuccess;
}

}  // namespace limber::bench
