// SPDX-License-Identifier: Zlib
#pragma once

#include "command_list.h"
#include "scaling/scaling_row.h"

#include <cstdint>
#include <string>
#include <variant>
#include <vector>

namespace limber::bench {

struct ScalingOptions {
  std::string out = "out/bench";
  std::vector<Mode> modes = {Mode::Bare, Mode::None, Mode::Shaded, Mode::Wireframe};
  std::vector<std::uint32_t> counts;  ///< cubes; empty: search for the largest number in real time
  double seconds = 10.0;              ///< simulated, per run
  std::uint32_t maxBodies = 65536;
  int width = 1280, height = 720;  ///< pixels of a frame
  int repeats = 3;                 ///< runs per row, where a run is short
  double minutes = 12.0;           ///< wall time after which no more rows are begun
  bool sleep = false;              ///< bodies at rest may fall asleep
};

/// Options, or the exit code of a run that is already over (--help or an error, which has been printed).
std::variant<ScalingOptions, ExitCode> parseScalingOptions(int argc, char** argv);

}  // namespace limber::bench
