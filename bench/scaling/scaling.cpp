// SPDX-License-Identifier: Zlib
// Repeats Tables 1 and 2 of C. Hart's paper: cubes fall onto a floor, 1, 2, 4 ... of them until 50 ticks a
// second are too many, then bisecting; with loose spheres beside them.
#include "bench.h"
#include "results.h"
#include "scaling/count_search.h"
#include "scaling/cubes.h"

#include <algorithm>
#include <cmath>

namespace limber::bench {
namespace {

// --- a run ---

/// What was measured at one count in one mode. Times are milliseconds of wall time unless said; means,
/// medians and maxima are over samples, one per tenth of a simulated second.
struct ScalingRow {
  Mode mode = Mode::None;
  std::uint32_t bodies = 0;
  std::size_t points = 0, springs = 0;

  double tickMean = 0.0, tickMedian = 0.0, tickMax = 0.0;
  double tickWorst = 0.0;    ///< of all ticks, sampled or not
  double tickCpuMean = 0.0;  ///< processor time of the sampled ticks
  TickProfile own;           ///< the plugin's part of the sampled ticks, means
  double renderMean = 0.0, renderMax = 0.0;
  std::size_t gpuBytes = 0;  ///< of buffers, without textures and render targets
  std::string driver;        ///< of OpenGL; empty without a renderer

  double realTime =
      0.0;  ///< simulated seconds per second, with a frame after each tick where there are frames
  double contacts = 0.0;     ///< mean number of touching pairs
  double asleepShare = 0.0;  ///< mean share of bodies asleep
  double simulatedSeconds = 0.0;
  bool complete = false;   ///< false: given up early, because too slow
  int repeats = 1;         ///< runs measured, of which this is the middle one
  bool repeatable = true;  ///< all runs ended in the same state, bit for bit
  std::uint64_t hash = 0;  ///< of the last state
};

/// When a run is given up.
struct RowLimits {
  bool mayGiveUp = false;      ///< as soon as it is clear that real time is lost
  double wallSeconds = 600.0;  ///< in any case after so long
};

// a sample each 100 ms, as in the paper
constexpr int kTicksPerSample = kTicksPerSecond / 10;

// runs longer than this are not repeated: they hold enough samples, and the bench has to end
constexpr double kShortRunSeconds = 4.0;

/// Everything one run leaves behind.
struct Recording {
  std::vector<double> allTicks;                 // #ticks, ms
  std::vector<double> ticks, ticksCpu, frames;  // #samples, ms; no frames without a renderer
  std::vector<double> contacts, asleep;         // #samples
  TickProfile own;                              // summed over the samples
};

double simulatedSeconds(const Recording& r) {
  return static_cast<double>(r.allTicks.size()) / kTicksPerSecond;
}

/// Seconds the run would have taken with a frame after each tick: frames are only drawn when sampled, which
/// saves four fifths of them.
double runSeconds(const Recording& r) {
  return 1e-3 * (sum(r.allTicks) + mean(r.frames) * static_cast<double>(r.allTicks.size()));
}

/// Falling is cheaper than lying on the floor, so a run that is far too slow while falling is lost.
bool isHopeless(const Recording& r, double seconds) {
  constexpr double kFallingSeconds = 0.5, kFarTooSlow = 3.0, kLost = 1.5;
  const double simulated = simulatedSeconds(r), run = runSeconds(r);
  return run > kLost * seconds || (simulated >= kFallingSeconds && run > kFarTooSlow * simulated);
}

void takeSample(Cubes& cubes, const WorkTime& time, Recording& r) {
  r.ticks.push_back(time.wallMs);
  r.ticksCpu.push_back(time.cpuMs);
  scenes::add(r.own, ownPart(cubes));
  r.contacts.push_back(static_cast<double>(contactCount(cubes)));
  r.asleep.push_back(asleepShare(cubes));
  if (cubes.renderer) r.frames.push_back(draw(cubes));
}

template <class Show>
Recording record(Cubes& cubes, double seconds, const RowLimits& limits, Show show) {
  const auto count = static_cast<std::size_t>(std::lround(seconds * kTicksPerSecond));
  const Stopwatch watch;
  Recording r;
  while (r.allTicks.size() < count) {
    const WorkTime time = tick(cubes);
    r.allTicks.push_back(time.wallMs);
    if (r.allTicks.size() % kTicksPerSample == 0) takeSample(cubes, time, r);
    if (watch.seconds() > limits.wallSeconds || (limits.mayGiveUp && isHopeless(r, seconds))) break;
    show(static_cast<double>(r.allTicks.size()) / static_cast<double>(count));
  }
  if (r.ticks.empty()) takeSample(cubes, tick(cubes), r);
  return r;
}

TickProfile meanOwn(const Recording& r) {
  const double count = static_cast<double>(r.ticks.size());
  TickProfile own = r.own;
  for (double* ms : {&own.readMs, &own.searchMs, &own.islandsMs, &own.chooseMs, &own.stepMs, &own.writeMs,
                     &own.readBackMs})
    *ms /= count;
  own.springSubsteps /= r.ticks.size();
  own.pointsStepped /= r.ticks.size();
  return own;
}

void fillTimes(const Recording& r, ScalingRow& row) {
  row.tickMean = mean(r.ticks);
  row.tickMedian = median(r.ticks);
  row.tickMax = largest(r.ticks);
  row.tickWorst = std::max(largest(r.allTicks), row.tickMax);
  row.tickCpuMean = mean(r.ticksCpu);
  row.own = meanOwn(r);
  row.renderMean = mean(r.frames);
  row.renderMax = largest(r.frames);
  row.realTime = runSeconds(r) > 0.0 ? simulatedSeconds(r) / runSeconds(r) : 0.0;
}

void fillState(const Cubes& cubes, const Recording& r, ScalingRow& row) {
  row.bodies = cubes.bodies;
  row.points = cubes.points;
  row.springs = cubes.springs;
  if (cubes.renderer) {
    row.gpuBytes = cubes.renderer->gpuBufferBytes();
    row.driver = cubes.renderer->driver();
  }
  row.contacts = mean(r.contacts);
  row.asleepShare = mean(r.asleep);
  row.simulatedSeconds = simulatedSeconds(r);
  row.hash = stateHash(cubes);
}

std::string settingOf(Mode mode) {
  const char* const names[] = {"", "not drawn", "shaded", "wireframe"};
  return names[static_cast<int>(mode)];
}

std::string engineOf(Mode mode) { return mode == Mode::Bare ? "loose spheres" : "Limber"; }

ScalingRow measureOnce(const ScalingOptions& options, Mode mode, std::uint32_t count, const RowLimits& limits,
                       Progress& progress) {
  Cubes cubes = makeCubes(options, mode, count);
  const std::string name = engineOf(mode) + " " + settingOf(mode) + ", " + std::to_string(count) + " cubes";
  const Recording r =
      record(cubes, options.seconds, limits, [&](double share) { progress.show(name, share); });
  ScalingRow row;
  row.mode = mode;
  fillTimes(r, row);
  fillState(cubes, r, row);
  row.complete = row.simulatedSeconds > options.seconds - 0.5 / kTicksPerSecond;
  return row;
}

/// The middle one by speed; of an even number the slower one.
ScalingRow middleOf(std::vector<ScalingRow> runs) {
  const auto sameEnd = [&](const ScalingRow& run) { return run.hash == runs[0].hash; };
  const bool repeatable = std::all_of(runs.begin(), runs.end(), sameEnd);
  std::sort(runs.begin(), runs.end(),
            [](const ScalingRow& a, const ScalingRow& b) { return a.realTime < b.realTime; });
  ScalingRow row = runs[(runs.size() - 1) / 2];
  row.repeats = static_cast<int>(runs.size());
  row.repeatable = repeatable;
  return row;
}

/// Returns a new scene of `count` cubes, run for the time asked for; the middle one of several runs where
/// they are short.
ScalingRow measureRow(const ScalingOptions& options, Mode mode, std::uint32_t count, const RowLimits& limits,
                      Progress& progress) {
  const Stopwatch watch;
  std::vector<ScalingRow> runs = {measureOnce(options, mode, count, limits, progress)};
  const bool isShort = runs[0].complete && watch.seconds() < kShortRunSeconds;
  for (int i = 1; isShort && i < options.repeats; ++i) {
    const ScalingRow again = measureOnce(options, mode, count, limits, progress);
    if (again.complete) runs.push_back(again);
  }
  return middleOf(runs);
}

std::string nameOf(std::uint32_t count) { return std::to_string(count) + (count == 1 ? " cube" : " cubes"); }

void addTimes(const Subject& subject, const ScalingRow& r, Results& results) {
  results.add(subject, "tick", "ms", r.tickMedian);
  results.add(subject, "tick, mean", "ms", r.tickMean);
  results.add(subject, "tick, largest sample", "ms", r.tickMax);
  results.add(subject, "worst tick", "ms", r.tickWorst);
  results.add(subject, "tick, own time", "ms", r.tickCpuMean);
  if (r.points) results.add(subject, "tick per point", "us", 1e3 * r.tickMean / double(r.points));
  if (r.mode != Mode::Bare) {
    results.add(subject, "Limber's part", "ms", r.own.totalMs());
    results.add(subject, "before the springs", "ms", r.own.beforeStepMs());
    results.add(subject, "springs", "ms", r.own.stepMs);
    results.add(subject, "writing to Bullet", "ms", r.own.writeMs);
    results.add(subject, "reading from Bullet", "ms", r.own.readBackMs);
  }
  if (isDrawn(r.mode)) {
    results.add(subject, "frame", "ms", r.renderMean);
    results.add(subject, "frame, largest", "ms", r.renderMax);
    results.add(subject, "buffers", "MB", 1e-6 * double(r.gpuBytes));
    results.note(subject, "driver", r.driver);
  }
}

void addRow(const ScalingRow& r, Results& results) {
  const Subject subject{"cubes", nameOf(r.bodies), engineOf(r.mode), settingOf(r.mode), kTicksPerSecond};
  results.add(subject, "bodies", "", r.bodies);
  results.add(subject, "points", "", double(r.points));
  results.add(subject, "springs per cube", "", double(r.springs) / r.bodies);
  addTimes(subject, r, results);
  results.add(subject, "simulated over real time", "", r.realTime);
  results.add(subject, "touching pairs", "", r.contacts);
  results.add(subject, "asleep", "%", 100.0 * r.asleepShare);
  results.add(subject, "simulated", "s", r.simulatedSeconds);
  results.add(subject, "complete", "", r.complete);
  results.add(subject, "runs", "", r.repeats);
  results.add(subject, "runs end alike", "", r.repeatable);
  results.note(subject, "hash", hexText(r.hash));
}

// --- the search ---

// the counts of the paper's tables: measured to the end, real time or not
constexpr std::uint32_t kPaperCount = 64;

struct ModeSearch {
  Mode mode;
  CountSearch search;

  bool isOver() const { return !search.next(); }
};

struct Run {
  const ScalingOptions& options;
  Results& results;
  Progress progress;
  Stopwatch watch;

  double secondsLeft() const { return 60.0 * options.minutes - watch.seconds(); }
};

std::vector<ModeSearch> startSearches(const ScalingOptions& options, const std::vector<Mode>& modes) {
  CountSearchSettings settings;
  settings.always = kPaperCount;
  settings.cap = options.maxBodies;
  std::vector<ModeSearch> searches;
  for (const Mode mode : modes) searches.push_back({mode, CountSearch(settings)});
  return searches;
}

ScalingRow measureAndKeep(Mode mode, std::uint32_t count, const RowLimits& limits, Run& run) {
  ScalingRow row = measureRow(run.options, mode, count, limits, run.progress);
  addRow(row, run.results);
  run.progress.finish(format("%-9s %5u cubes: tick %.3f ms, %.2f x real time%s", settingOf(mode).c_str(),
                             row.bodies, row.tickMean, row.realTime, row.complete ? "" : " (given up)"));
  return row;
}

void advance(ModeSearch& search, double seconds, Run& run) {
  const std::uint32_t count = *search.search.next();
  const RowLimits limits{count > kPaperCount, seconds};
  const ScalingRow row = measureAndKeep(search.mode, count, limits, run);
  search.search.report(row.realTime >= 1.0);
}

std::ptrdiff_t countUnfinished(const std::vector<ModeSearch>& searches) {
  return std::count_if(searches.begin(), searches.end(), [](const ModeSearch& s) { return !s.isOver(); });
}

/// No row may take more than its mode's share of the time that is left.
void searchAll(std::vector<ModeSearch>& searches, Run& run) {
  while (countUnfinished(searches) > 0 && run.secondsLeft() > 0.0) {
    for (ModeSearch& search : searches) {
      if (search.isOver()) continue;
      const double share = run.secondsLeft() / static_cast<double>(countUnfinished(searches));
      if (share > 0.0) advance(search, share, run);
    }
  }
}

void addEnd(const ModeSearch& s, Results& results) {
  const bool timeUp = s.search.next().has_value();
  const Subject subject{"largest number in real time", "cubes", engineOf(s.mode), settingOf(s.mode),
                        kTicksPerSecond};
  results.add(subject, "cubes in real time", "", s.search.largest());
  if (timeUp) results.note(subject, "or more", "stopped by the time limit");
  if (!timeUp && !s.search.foundFailure()) results.note(subject, "or more", "the largest count allowed");
}

/// --quick is weaker than what is given by name.
ScalingOptions scalingOptions(const Options& options) {
  const bool quick = options.quick;
  ScalingOptions o;
  o.seconds = options.number("seconds", quick ? 1.0 : 10.0);
  o.maxBodies = static_cast<std::uint32_t>(options.number("maxBodies", quick ? 256 : 65536));
  o.repeats = static_cast<int>(options.number("repeats", quick ? 1 : 3));
  o.minutes = options.number("minutes", quick ? 0.75 : 12.0);
  o.width = static_cast<int>(options.number("width", quick ? 320 : 1280));
  o.height = static_cast<int>(options.number("height", quick ? 180 : 720));
  o.sleep = options.word("sleep") == "yes";
  return o;
}

void runScaling(const Options& options, Results& results) {
  const ScalingOptions own = scalingOptions(options);
  std::vector<Mode> modes;
  for (const Mode mode : {Mode::Bare, Mode::None, Mode::Shaded, Mode::Wireframe})
    if (options.wantsEngine(engineOf(mode), settingOf(mode))) modes.push_back(mode);
  Run run{own, results, {}, {}};
  for (const double count : options.numbers("counts", {}))
    for (const Mode mode : modes) measureAndKeep(mode, static_cast<std::uint32_t>(count), RowLimits(), run);
  if (!options.word("counts").empty()) return;
  std::vector<ModeSearch> searches = startSearches(own, modes);
  searchAll(searches, run);
  for (const ModeSearch& search : searches) addEnd(search, results);
}

}  // namespace

Bench scalingBench() {
  return {"scaling",
          "the paper's Tables 1 and 2: cubes until real time is lost",
          "12 minutes",
          {{"counts", "measure these numbers of cubes instead of searching", 1, 1048576, {}, true},
           {"seconds", "simulated time of a run", 0.1, 600},
           {"maxBodies", "largest number of cubes", 1, 1048576},
           {"repeats", "runs per row if they take 4 s at most", 1, 99},
           {"minutes", "wall time after which no more rows are begun", 0.01, 1e4},
           {"width", "pixels of a frame", 16, 8192},
           {"height", "pixels of a frame", 16, 8192},
           {"sleep", "bodies at rest may fall asleep", 0, 0, {"yes", "no"}}},
          nullptr,
          &runScaling};
}

}  // namespace limber::bench
