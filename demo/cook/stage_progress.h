// SPDX-License-Identifier: Zlib
#pragma once

#include "progress.h"

#include <chrono>
#include <cstdio>
#include <optional>
#include <string>

namespace limber::demo {

/// A bar for each thing that is done, one below the other.
class StageProgress {
 public:
  /// What is over within `patience` seconds gets no bar.
  StageProgress(std::FILE* stream, bool terminal, double patience)
      : stream_(stream), terminal_(terminal), patience_(patience) {}

  /// `done`: 0 to 1 of the stage. Another name, or less than before, ends the stage before.
  void show(const std::string& stage, double done);
  /// Fills the last bar up, so that what is printed next has a line of its own.
  void finish();

 private:
  void begin(const std::string& stage);

  std::FILE* stream_;
  bool terminal_;
  double patience_;
  std::optional<Progress> bar_;
  std::string stage_;
  std::chrono::steady_clock::time_point start_;
  long long steps_ = 0;
  bool open_ = false;  // a bar is on the screen and not yet full
};

}  // namespace limber::demo
