// SPDX-License-Identifier: Zlib
#pragma once

#include <vector>

namespace limber::bench {

/// 1: something failed; 2: the command line is wrong.
enum ExitCode : int { kSuccess = 0, kFailure = 1, kUsage = 2 };

/// A table or plot that can be asked for by name.
struct Command {
  const char* name;
  const char* about;                       ///< one line
  ExitCode (*run)(int argc, char** argv);  ///< argv[0] is the name, its own options follow
};

const std::vector<Command>& commandList();

/// Runs the command that argv[1] names; an unknown name is refused with the list.
ExitCode runCommand(int argc, char** argv);

}  // namespace limber::bench
