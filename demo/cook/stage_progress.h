// SPDX-License-Identifier: Zlib
#pragma once

#include "progress.h"

#include <cstdio>
#include <optional>
#include <string>

namespace limber::demo {

/// A bar for each thing that is done, one below the other.
class StageProgress {
 public:
  StageProgress(std::FILE* stream, bool terminal) : stream_(stream), terminal_(terminal) {}

  /// `done`: 0 to 1 of the stage. A new name ends the stage before.
  void show(const std::string& stage, double done);
  /// Fills the last bar up, so that what is printed next has a line of its own.
  void finish();

 private:
  std::FILE* stream_;
  bool terminal_;
  std::string stage_;
  bool full_ = true;
  std::optional<Progress> bar_;
};

}  // namespace limber::demo
