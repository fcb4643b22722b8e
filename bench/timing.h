// SPDX-License-Identifier: Zlib
#pragma once

// Clocks, statistics of samples, and progress on the terminal.

#include <chrono>
#include <string>
#include <vector>

namespace limber::bench {

/// Times of a piece of work. They differ where other programs held the processor.
struct WorkTime {
  double wallMs = 0.0;
  double cpuMs = 0.0;  ///< of this thread alone
};

/// Returns the time of all threads of this process so far.
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

// --- statistics: all return 0 without samples --------------------------------------------------------------

double sum(const std::vector<double>& samples);
double mean(const std::vector<double>& samples);
double largest(const std::vector<double>& samples);
/// Returns the sample at this share of the sorted ones, interpolated: 0.5 is the median.
double quantile(std::vector<double> samples, double share);
double median(std::vector<double> samples);

// --- progress ----------------------------------------------------------------------------------------------

/// On standard error: a line for each finished part and, on a terminal, a bar for the part that runs.
class Progress {
 public:
  Progress();

  /// The part called `name` is done to this share (0 to 1).
  void show(const std::string& name, double share);
  /// Replaces the bar by a line about the finished part.
  void finish(const std::string& line);

 private:
  void wipe();

  bool terminal_;
  std::chrono::steady_clock::time_point start_, shown_;
  std::size_t width_ = 0;  // of the bar on the screen
};

}  // namespace limber::bench
