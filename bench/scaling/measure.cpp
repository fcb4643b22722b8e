// SPDX-License-Identifier: Zlib
#include "scaling/measure.h"

#include "sample_stats.h"
#include "scaling/subject.h"

#include <algorithm>
#include <cmath>

namespace limber::bench {
namespace {

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

void takeSample(Subject& subject, const WorkTime& time, Recording& r) {
  r.ticks.push_back(time.wallMs);
  r.ticksCpu.push_back(time.cpuMs);
  scenes::add(r.own, ownPart(subject));
  r.contacts.push_back(static_cast<double>(contactCount(subject)));
  r.asleep.push_back(asleepShare(subject));
  if (subject.renderer) r.frames.push_back(draw(subject));
}

template <class Show>
Recording record(Subject& subject, double seconds, const RowLimits& limits, Show show) {
  const auto count = static_cast<std::size_t>(std::lround(seconds * kTicksPerSecond));
  const Stopwatch watch;
  Recording r;
  while (r.allTicks.size() < count) {
    const WorkTime time = tick(subject);
    r.allTicks.push_back(time.wallMs);
    if (r.allTicks.size() % kTicksPerSample == 0) takeSample(subject, time, r);
    if (watch.seconds() > limits.wallSeconds || (limits.mayGiveUp && isHopeless(r, seconds))) break;
    show(static_cast<double>(r.allTicks.size()) / static_cast<double>(count));
  }
  if (r.ticks.empty()) takeSample(subject, tick(subject), r);
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

void fillState(const Subject& subject, const Recording& r, ScalingRow& row) {
  row.bodies = subject.bodies;
  row.points = subject.points;
  row.springs = subject.springs;
  if (subject.renderer) {
    row.gpuBytes = subject.renderer->gpuBufferBytes();
    row.driver = subject.renderer->driver();
  }
  row.contacts = mean(r.contacts);
  row.asleepShare = mean(r.asleep);
  row.simulatedSeconds = simulatedSeconds(r);
  row.hash = stateHash(subject);
}

ScalingRow measureOnce(const ScalingOptions& options, Mode mode, std::uint32_t count, const RowLimits& limits,
                       RowProgress& progress) {
  Subject subject = makeSubject(options, mode, count);
  const std::string name = std::string(nameOf(mode)) + ", " + std::to_string(count) + " cubes";
  const Recording r =
      record(subject, options.seconds, limits, [&](double share) { progress.show(name, share); });
  ScalingRow row;
  row.mode = mode;
  fillTimes(r, row);
  fillState(subject, r, row);
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

}  // namespace

ScalingRow measureRow(const ScalingOptions& options, Mode mode, std::uint32_t count, const RowLimits& limits,
                      RowProgress& progress) {
  const Stopwatch watch;
  std::vector<ScalingRow> runs = {measureOnce(options, mode, count, limits, progress)};
  const bool isShort = runs[0].complete && watch.seconds() < kShortRunSeconds;
  for (int i = 1; isShort && i < options.repeats; ++i) {
    const ScalingRow again = measureOnce(options, mode, count, limits, progress);
    if (again.complete) runs.push_back(again);
  }
  return middleOf(runs);
}

}  // namespace limber::bench
