// SPDX-License-Identifier: Zlib
#include "command_list.h"

#include <cstdio>
#include <exception>

int main(int argc, char** argv) {
  using namespace limber::bench;
  try {
    return runCommand(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "limber-bench: %s\n", error.what());
    return kFailure;
  }
}
