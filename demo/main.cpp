// SPDX-License-Identifier: Zlib
#include "demo_options.h"
#include "run_demo.h"
#include "window/run_window.h"

#include <csignal>
#include <cstdio>
#include <exception>
#include <variant>

namespace {

/// Only the first signal stops the run in an orderly way; a second one ends the program.
void stopAt(int signal) {
  limber::demo::stopSignal = signal;
  std::signal(signal, SIG_DFL);
}

limber::demo::ExitCode run(const limber::demo::DemoOptions& options) {
  if (options.window.open) return limber::demo::runWindow(options);
  if (!options.window.replay.empty()) return limber::demo::runReplay(options);
  return limber::demo::runDemo(options);
}

}  // namespace

int main(int argc, char** argv) {
  using namespace limber::demo;
  for (const int signal : {SIGINT, SIGTERM}) std::signal(signal, stopAt);
  std::signal(SIGXFSZ, SIG_IGN);  // a file over the size limit is then an error, like a full disk
  try {
    const ParsedOptions parsed = parseOptions(argc, argv);
    if (const ExitCode* exitCode = std::get_if<ExitCode>(&parsed)) return *exitCode;
    return run(std::get<DemoOptions>(parsed));
  } catch (const Stopped&) {
    std::fprintf(stderr, "limber-demo: stopped\n");
    return 128 + stopSignal;  // the usual exit code of shells
  } catch (const std::exception& error) {
    std::fprintf(stderr, "limber-demo: %s\n", error.what());
    return kFailure;
  }
}
