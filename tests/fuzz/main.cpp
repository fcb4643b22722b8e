// SPDX-License-Identifier: Zlib
// limber_fuzz plays random worlds with soft bodies and random actions of a user.
#include "fuzz/campaign.h"
#include "fuzz/generator.h"

#include <CLI/CLI.hpp>

#include <cstdio>
#include <fstream>
#include <sstream>

#if defined(__SANITIZE_ADDRESS__)
extern "C" const char* __asan_default_options() { return "halt_on_error=1:detect_leaks=1"; }
extern "C" const char* __ubsan_default_options() { return "halt_on_error=1:print_stacktrace=1"; }
#endif

namespace {

using namespace limber::fuzz;

/// The seeds of every test run. The last ones broke laws that no other test checks.
const char* const kTestedSeeds = "1..48,878,2337,6211,7072,59505,61597";

struct Options {
  std::string seeds, replay, out, frames;
  bool shrinks = false, prints = false, here = false, traces = false;
  Effort effort;
};

/// Reads seeds: "A..B" or "A", or several of these separated by commas.
std::vector<std::uint64_t> seedsOf(const std::string& text) {
  std::vector<std::uint64_t> seeds;
  std::istringstream ranges(text);
  for (std::string range; std::getline(ranges, range, ',');) {
    const std::size_t dots = range.find("..");
    const std::uint64_t first = std::stoull(range);
    const std::uint64_t last = dots == std::string::npos ? first : std::stoull(range.substr(dots + 2));
    for (std::uint64_t seed = first; seed <= last; ++seed) seeds.push_back(seed);
  }
  return seeds;
}

/// Returns why `text` is not a list of seeds, or an empty string if it is one.
std::string wrongSeeds(const std::string& text) {
  try {
    if (!seedsOf(text).empty()) return {};
  } catch (const std::logic_error&) {
  }
  return "'" + text + "' names no seeds; write 7, 1..48 or 1..48,878";
}

std::string firstLine(const std::string& text) { return text.substr(0, text.find('\n')); }

void report(const Options& options, const Story& story, const Verdict& verdict) {
  std::printf("seed %llu: %s: %s\n", static_cast<unsigned long long>(story.seed), verdict.law.c_str(),
              verdict.law == "crash" ? verdict.detail.c_str() : firstLine(verdict.detail).c_str());
  if (!options.shrinks) return;
  const Story small = shrink(story, verdict, options.effort);
  std::printf("shrunken:\n%s\n", toText(small).c_str());
  if (options.out.empty()) return;
  std::ofstream file(options.out + "/" + std::to_string(story.seed) + ".story");
  file << "// " << verdict.law << ": " << firstLine(verdict.detail) << "\n" << toText(small);
}

int runSeeds(const Options& options, const std::vector<std::uint64_t>& seeds) {
  std::size_t failures = 0;
  // in batches, because stories take memory; large ones, because the slowest story of each is waited for
  const std::size_t batch = 256 * static_cast<std::size_t>(std::max(1, options.effort.jobs));
  for (std::size_t begin = 0; begin < seeds.size(); begin += batch) {
    std::vector<Story> stories;
    for (std::size_t i = begin; i < std::min(seeds.size(), begin + batch); ++i)
      stories.push_back(makeStory(seeds[i]));
    std::vector<std::pair<std::size_t, Verdict>> failed;
    judge(stories, options.effort, [&](std::size_t i, const Verdict& verdict) {
      if (verdict.failed()) failed.emplace_back(i, verdict);
    });
    for (const auto& [i, verdict] : failed) report(options, stories[i], verdict);
    failures += failed.size();
    std::fflush(stdout);
  }
  std::printf("%llu stories, %zu failed\n", static_cast<unsigned long long>(seeds.size()), failures);
  return failures > 0;
}

void trace(const Story& story) {
  const Run run = play(story);
  for (std::size_t i = 0; i < run.frames.size(); ++i) {
    std::printf("%4ld %12.6f J%s", static_cast<long>(i) - 1, run.frames[i].energy,
                run.frames[i].near ? " near" : "");
    for (const auto& [id, points] : run.frames[i].soft) {
      const Eigen::Vector3d mean = points.rowwise().mean();
      std::printf("  #%d %.6f %.6f %.6f low %.6f", id, mean.x(), mean.y(), mean.z(),
                  points.row(1).minCoeff());
    }
    std::printf("\n");
  }
}

int runStory(const Options& options, const Story& story) {
  if (options.prints) std::printf("%s", toText(story).c_str());
  if (options.traces) trace(story);
  if (options.here) {
    prepare(story);
    const auto failure = checkStory(story, options.effort.laws);
    if (!options.frames.empty()) writeFrames(play(story), options.frames);
    std::printf("%s\n", failure ? (failure->law + ": " + failure->detail).c_str() : "all laws hold");
    return failure ? 1 : 0;
  }
  const Verdict verdict = judge(story, options.effort);
  if (verdict.failed())
    report(options, story, verdict);
  else
    std::printf("all laws hold\n");
  return verdict.failed();
}

}  // namespace

int main(int count, char** words) {
  CLI::App app("Plays random worlds with soft bodies and looks for broken laws.");
  Options options;
  app.add_option("--seed,--seeds", options.seeds, "one story, a range A..B, or several of them behind commas")
      ->check(wrongSeeds)
      ->envname("LIMBER_FUZZ_SEEDS");
  app.add_option("--replay", options.replay, "a file with a story");
  app.add_option("--jobs", options.effort.jobs, "processes at a time");
  app.add_option("--seconds", options.effort.seconds, "processor time that a story may take");
  app.add_flag("--once", options.effort.laws.once,
               "plays it once, for sanitizers: nothing is compared with other runs");
  app.add_option("--threads", options.effort.laws.threads, "on which soft bodies are stepped (default 1)")
      ->check(CLI::Range(1, 64));
  app.add_option("--beside", options.effort.laws.beside,
                 "a limber_fuzz of another precision, which must play it alike");
  app.add_option("--frames", options.frames, "file for the points of a story that is played --here");
  app.add_option("--out", options.out, "folder for shrunken stories");
  app.add_flag("--shrink", options.shrinks, "shrinks what fails");
  app.add_flag("--print", options.prints, "prints the story");
  app.add_flag("--trace", options.traces, "prints energy, centres and lowest points, frame by frame");
  app.add_flag("--here", options.here, "plays it in this process, for a debugger");
  CLI11_PARSE(app, count, words);
  if (!options.replay.empty()) {
    std::ifstream file(options.replay);
    std::ostringstream text;
    text << file.rdbuf();
    return runStory(options, fromText(text.str()));
  }
  if (options.seeds.empty()) options.seeds = kTestedSeeds;
  const std::vector<std::uint64_t> seeds = seedsOf(options.seeds);
  return seeds.size() > 1 ? runSeeds(options, seeds) : runStory(options, makeStory(seeds.front()));
}
