// SPDX-License-Identifier: Zlib
#include "command_line.h"

#include "output_folder.h"

#include <cstdio>
#include <fstream>

namespace limber::bench {

std::optional<ExitCode> parse(CLI::App& app, int argc, char** argv) {
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? kSuccess : kUsage;
  }
  return std::nullopt;
}

bool canWrite(const std::string& folder, const std::string& fileName) {
  const std::string reason = prepareOutput(folder, fileName);
  if (!reason.empty()) std::fprintf(stderr, "limber-bench: %s\n", reason.c_str());
  return reason.empty();
}

void publish(const std::string& summary, const std::string& file) {
  std::ofstream(file) << summary;
  std::printf("%s", summary.c_str());
}

}  // namespace limber::bench
