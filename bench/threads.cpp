// SPDX-License-Identifier: Zlib
// Gain of several threads. Each scene runs once without a parallel function, once with one that measures the
// parallel parts on one thread, and once on each number of threads, all in turns.
#include "contact/contact.h"
#include "results.h"
#include "timing.h"

#include <algorithm>
#include <deque>
#include <thread>

namespace limber::bench {
namespace {

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

std::vector<unsigned> threadCounts() {
  const unsigned most = std::max(2u, std::thread::hardware_concurrency());
  std::vector<unsigned> counts;
  for (unsigned n = 2; n < most; n *= 2) counts.push_back(n);
  counts.push_back(most);
  return counts;
}

/// Plays all stages in turns: threads of other stages sleep while one runs.
void play(std::deque<ContactStage>& stages, int ticks, int turn) {
  for (int done = 0; done < ticks; done += turn)
    for (ContactStage& stage : stages) stage.advance(std::min(turn, ticks - done), 1e9);
}

/// Results of the repeats of a scene, first without a parallel function, then timed, then on several threads.
struct Samples {
  std::vector<std::vector<double>> tick, gain;  // ms; #runs, #repeats
  std::vector<double> outside;                  // share of the tick outside the parallel parts, on one thread
  std::string error;                            // why a run did not finish
};

void measureOnce(const ContactScene& scene, const Options& options, Samples& samples) {
  TimedInOrder timed;
  std::deque<ThreadPool> pools;
  std::vector<EngineChoice> choices = {usersLimber("1 thread"),
                                       usersLimber("1 thread, timed", {}, timed.function())};
  for (const unsigned count : threadCounts())
    choices.push_back(usersLimber(std::to_string(count), {}, pools.emplace_back(count).parallelFor()));
  Options anyEngine = options;
  anyEngine.engines.clear();
  std::deque<ContactStage> stages;
  for (const EngineChoice& choice : wantedEngines(choices, anyEngine)) stages.emplace_back(scene, choice);
  play(stages, scene.settleTicks, scene.turn);
  const double settling = timed.milliseconds;
  play(stages, scene.measuredTicks, scene.turn);
  for (const ContactStage& stage : stages)
    if (samples.error.empty()) samples.error = stage.error();
  if (!samples.error.empty()) return;
  samples.tick.resize(stages.size()), samples.gain.resize(stages.size());
  const double single = median(stages[0].wallTicks());
  for (std::size_t i = 0; i < stages.size(); ++i) {
    samples.tick[i].push_back(median(stages[i].wallTicks()));
    samples.gain[i].push_back(single / samples.tick[i].back());
  }
  const double inside = timed.milliseconds - settling;
  samples.outside.push_back(std::clamp(1.0 - inside / std::max(sum(stages[1].wallTicks()), 1e-9), 0.0, 1.0));
}

/// Returns the gain of so many threads if the parallel parts cost nothing but their work (Amdahl 1967).
double largestGain(double outside, unsigned threads) { return 1.0 / (outside + (1.0 - outside) / threads); }

void addRows(const ContactScene& scene, const Samples& samples, Results& results) {
  const Subject single{nameOf(scene.role), scene.name, "Limber", "1 thread", 1.0 / kContactTick};
  if (!samples.error.empty()) return results.note(single, "no result", samples.error);
  std::vector<unsigned> threads = threadCounts();
  threads.insert(threads.begin(), 1);
  const double outside = median(samples.outside);
  for (std::size_t i = 0; i < threads.size(); ++i) {
    const std::size_t run = i == 0 ? 0 : i + 1;  // without the timed one
    const Subject subject{nameOf(scene.role), scene.name, "Limber",
                          std::to_string(threads[i]) + (i == 0 ? " thread" : " threads"), 1.0 / kContactTick};
    results.add(subject, "threads", "", threads[i]);
    results.add(subject, "tick, wall time", "ms", samples.tick[run]);
    results.add(subject, "gain", "", samples.gain[run]);
    results.add(subject, "largest possible gain", "", largestGain(outside, threads[i]));
  }
  results.add(single, "outside the parallel parts", "%", 100.0 * outside);
  for (const unsigned count : {8u, 64u})
    results.add(single, "largest possible gain of " + std::to_string(count) + " threads", "",
                largestGain(outside, count));
}

/// Returns the scenes with awake bodies.
std::vector<ContactScene> awakeScenes(const Options& options) {
  std::vector<ContactScene> scenes = wantedScenes(allContactScenes(options.quick), options);
  scenes.erase(std::remove_if(scenes.begin(), scenes.end(), [](const ContactScene& s) { return s.sleeps(); }),
               scenes.end());
  return scenes;
}

void runThreads(const Options& options, Results& results) {
  Progress progress;
  const int repeats = static_cast<int>(options.number("repeats", 3));
  for (const ContactScene& scene : awakeScenes(options)) {
    Samples samples;
    for (int i = 0; i < repeats && samples.error.empty(); ++i) {
      progress.show(scene.name, double(i) / repeats);
      measureOnce(scene, options, samples);
    }
    addRows(scene, samples, results);
    progress.finish(scene.name);
  }
}

}  // namespace

Bench threadsBench() {
  return {"threads",
          "gain of several threads, and the most that more threads could gain",
          "13 minutes",
          withEngineKeys({{"repeats", "repeats of each scene", 1, 100}}),
          [](const Options& options) { return namesOf(awakeScenes(options)); },
          &runThreads};
}

}  // namespace limber::bench
