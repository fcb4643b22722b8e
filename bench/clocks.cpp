// SPDX-License-Identifier: Zlib
#include "clocks.h"

#include <time.h>

namespace limber::bench {
namespace {

double readClock(clockid_t clock) {
  timespec now{};
  clock_gettime(clock, &now);
  return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}

double threadCpuMs() { return readClock(CLOCK_THREAD_CPUTIME_ID); }

}  // namespace

double processCpuMs() { return readClock(CLOCK_PROCESS_CPUTIME_ID); }

Stopwatch::Stopwatch() : wallStart_(std::chrono::steady_clock::now()), cpuStart_(threadCpuMs()) {}

WorkTime Stopwatch::time() const {
  const std::chrono::duration<double, std::milli> wall = std::chrono::steady_clock::now() - wallStart_;
  return {wall.count(), threadCpuMs() - cpuStart_};
}

}  // namespace limber::bench
