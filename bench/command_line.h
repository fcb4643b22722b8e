// SPDX-License-Identifier: Zlib
#pragma once

#include "command_list.h"

#include <CLI/CLI.hpp>

#include <optional>
#include <string>

namespace limber::bench {

/// Fills in what the options refer to. The exit code, where the program is to end at once: --help, or a wrong
/// command line, which has then been complained about.
std::optional<ExitCode> parse(CLI::App& app, int argc, char** argv);

/// prepareOutput(), with the reason on standard error.
bool canWrite(const std::string& folder, const std::string& fileName);

/// Prints a summary and writes it to a file.
void publish(const std::string& summary, const std::string& file);

}  // namespace limber::bench
