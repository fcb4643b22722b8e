// SPDX-License-Identifier: Zlib
#include "scaling/scaling_options.h"

#include "command_line.h"
#include "number_checks.h"

#include <CLI/CLI.hpp>

#include <map>

namespace limber::bench {
namespace {

/// What CLI11 fills in.
struct CommandLine {
  ScalingOptions options;
  bool quick = false;
  std::string size = "1280x720";
  std::vector<std::string> modes = {"bare", "none", "shaded", "wireframe"};
  CLI::Option *seconds = nullptr, *maxBodies = nullptr, *repeats = nullptr, *minutes = nullptr,
              *sizeGiven = nullptr;
};

void addOptions(CLI::App& app, CommandLine& line) {
  using demo::number;
  using demo::wholeNumber;
  ScalingOptions& o = line.options;
  app.add_option("--out", o.out, "folder of scaling.csv and scaling.txt (default out/bench)");
  app.add_flag("--quick", line.quick,
               "1 s of simulation, 1 run per row, frames of 320x180, at most 256 cubes and 45 s");
  app.add_option("--counts", o.counts, "measure these numbers of cubes, as in 64,512, instead of searching")
      ->delimiter(',')
      ->check(wholeNumber(1, 1048576));
  line.seconds =
      app.add_option("--seconds", o.seconds, "simulated time of a run (default 10)")->check(number(0.1, 600));
  line.maxBodies = app.add_option("--max-bodies", o.maxBodies, "largest number of cubes (default 65536)")
                       ->check(wholeNumber(1, 1048576));
  line.repeats = app.add_option("--repeats", o.repeats, "runs per row if they take 4 s at most (default 3)")
                     ->check(wholeNumber(1, 99));
  line.minutes =
      app.add_option("--minutes", o.minutes, "wall time after which no more rows are begun (default 12)")
          ->check(number(0.01, 1e4));
  line.sizeGiven = app.add_option("--size", line.size, "of the frames, WIDTHxHEIGHT (default 1280x720)")
                       ->check(demo::pictureSize());
  app.add_option("--modes", line.modes, "some of bare,none,shaded,wireframe (default all)")
      ->delimiter(',')
      ->check(CLI::IsMember({"bare", "none", "shaded", "wireframe"}));
  app.add_flag("--sleep", o.sleep, "let bodies at rest fall asleep, as they do in a game");
}

std::vector<Mode> modesNamed(const std::vector<std::string>& names) {
  std::vector<Mode> modes;
  for (const Mode mode : {Mode::Bare, Mode::None, Mode::Shaded, Mode::Wireframe}) {
    for (const std::string& name : names) {
      if (name == nameOf(mode) && (modes.empty() || modes.back() != mode)) modes.push_back(mode);
    }
  }
  return modes;
}

/// What is asked for by name counts for more than --quick.
void hurry(CommandLine& line) {
  ScalingOptions& o = line.options;
  if (line.seconds->count() == 0) o.seconds = 1.0;
  if (line.maxBodies->count() == 0) o.maxBodies = 256;
  if (line.repeats->count() == 0) o.repeats = 1;
  if (line.minutes->count() == 0) o.minutes = 0.75;
  if (line.sizeGiven->count() == 0) line.size = "320x180";
}

}  // namespace

std::variant<ScalingOptions, ExitCode> parseScalingOptions(int argc, char** argv) {
  CLI::App app("How many soft cubes can fall onto a floor in real time, at 50 ticks a second?",
               "limber-bench scaling");
  CommandLine line;
  addOptions(app, line);
  if (const auto end = parse(app, argc, argv)) return *end;
  if (line.quick) hurry(line);
  line.options.modes = modesNamed(line.modes);
  demo::parseSize(line.size, line.options.width, line.options.height);
  return line.options;
}

}  // namespace limber::bench
