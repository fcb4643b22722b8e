// SPDX-License-Identifier: Zlib
#include "row_progress.h"

#include "progress.h"

#include <cstdio>

namespace limber::bench {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds kRedraw(200);  // oftener than that only costs time

}  // namespace

RowProgress::RowProgress() : terminal_(demo::isTerminal(stderr)), start_(Clock::now()), shown_(start_) {}

void RowProgress::show(const std::string& name, double share) {
  if (!terminal_ || Clock::now() - shown_ < kRedraw) return;
  shown_ = Clock::now();
  wipe();
  const std::string bar = demo::barText(share, 30) + " " + name;
  std::fputs(bar.c_str(), stderr);
  std::fflush(stderr);
  width_ = bar.size();
}

void RowProgress::finish(const std::string& line) {
  wipe();
  const std::chrono::duration<double> elapsed = Clock::now() - start_;
  std::fprintf(stderr, "%5.0f s  %s\n", elapsed.count(), line.c_str());
}

void RowProgress::wipe() {
  if (width_ > 0) std::fprintf(stderr, "\r%s\r", std::string(width_, ' ').c_str());
  width_ = 0;
}

}  // namespace limber::bench
