// SPDX-License-Identifier: Zlib
#include "cook/cook_options.h"

#include <cstdio>
#include <exception>
#include <variant>

int main(int argc, char** argv) {
  using namespace limber::demo;
  try {
    const ParsedCookOptions parsed = parseCookOptions(argc, argv);
    if (const ExitCode* exitCode = std::get_if<ExitCode>(&parsed)) return *exitCode;
    return runCook(std::get<CookOptions>(parsed));
  } catch (const std::exception& error) {
    std::fprintf(stderr, "limber-cook: %s\n", error.what());
    return kFailure;
  }
}
