// SPDX-License-Identifier: Zlib
#include "timing.h"

#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <numeric>

namespace limber::bench {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds kRedraw(200);  // more often only costs time

double readClock(clockid_t clock) {
  timespec now{};
  clock_gettime(clock, &now);
  return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}

double threadCpuMs() { return readClock(CLOCK_THREAD_CPUTIME_ID); }

}  // namespace

double processCpuMs() { return readClock(CLOCK_PROCESS_CPUTIME_ID); }

Stopwatch::Stopwatch() : wallStart_(Clock::now()), cpuStart_(threadCpuMs()) {}

WorkTime Stopwatch::time() const {
  const std::chrono::duration<double, std::milli> wall = Clock::now() - wallStart_;
  return {wall.count(), threadCpuMs() - cpuStart_};
}

double sum(const std::vector<double>& samples) {
  return std::accumulate(samples.begin(), samples.end(), 0.0);
}

double mean(const std::vector<double>& samples) {
  return samples.empty() ? 0.0 : sum(samples) / static_cast<double>(samples.size());
}

double largest(const std::vector<double>& samples) {
  return samples.empty() ? 0.0 : *std::max_element(samples.begin(), samples.end());
}

double quantile(std::vector<double> samples, double share) {
  if (samples.empty()) return 0.0;
  std::sort(samples.begin(), samples.end());
  const double index = share * static_cast<double>(samples.size() - 1);
  const auto lower = static_cast<std::size_t>(index), upper = std::min(lower + 1, samples.size() - 1);
  const double part = index - static_cast<double>(lower);
  return (1.0 - part) * samples[lower] + part * samples[upper];
}

double median(std::vector<double> samples) { return quantile(std::move(samples), 0.5); }

Progress::Progress() : terminal_(isatty(STDERR_FILENO)), start_(Clock::now()), shown_(start_) {}

void Progress::show(const std::string& name, double share) {
  if (!terminal_ || Clock::now() - shown_ < kRedraw) return;
  shown_ = Clock::now();
  wipe();
  constexpr double kWidth = 30.0;
  const auto filled = static_cast<std::size_t>(kWidth * std::clamp(share, 0.0, 1.0));
  std::string bar(static_cast<std::size_t>(kWidth), '-');
  std::fill_n(bar.begin(), filled, '#');
  bar = "[" + bar + "] " + name;
  std::fputs(bar.c_str(), stderr);
  std::fflush(stderr);
  width_ = bar.size();
}

void Progress::finish(const std::string& line) {
  wipe();
  const std::chrono::duration<double> elapsed = Clock::now() - start_;
  std::fprintf(stderr, "%5.0f s  %s\n", elapsed.count(), line.c_str());
}

void Progress::wipe() {
  if (width_ > 0) std::fprintf(stderr, "\r%s\r", std::string(width_, ' ').c_str());
  width_ = 0;
}

}  // namespace limber::bench
