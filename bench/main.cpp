// SPDX-License-Identifier: Zlib
#include "bench.h"

#include <cstdio>
#include <exception>

int main(int argc, char** argv) {
  using namespace limber::bench;
  try {
#ifdef LIMBER_BENCH_DRAWS
    return runBench({renderBench(), scalingBench()}, argc, argv);
#else
    return runBench(
        {accuracyBench(), stabilityBench(), networksBench(), contactBench(), threadsBench(), springsBench()},
        argc, argv);
#endif
  } catch (const std::exception& error) {
    std::fprintf(stderr, "limber-bench: %s\n", error.what());
    return kFailure;
  }
}
