// SPDX-License-Identifier: Zlib
#pragma once

#include <chrono>

namespace limber::bench {

/// What a piece of work took. The two differ where other programs held the processor.
struct WorkTime {
  double wallMs = 0.0;
  double cpuMs = 0.0;  ///< of this thread alone
};

/// What all threads of this process together have taken so far.
double processCpuMs();

/// Runs from its construction on.
class Stopwatch {
 public:
  Stopwatch();
  WorkTime time() const;
  double seconds() const { return 1e-3 * time().wallMs; }

 private:
  std::chrono::steady_clock::time_point wallStart_;
  double cpuStart_;
};

}  // namespace limber::bench
