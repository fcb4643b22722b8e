// SPDX-License-Identifier: Zlib
#pragma once

#include <chrono>
#include <string>

namespace limber::bench {

/// On standard error: a line for each finished row and, on a terminal, a bar for the row being measured.
class RowProgress {
 public:
  RowProgress();

  /// The row called `name` is done to this share (0 to 1).
  void show(const std::string& name, double share);
  /// Replaces the bar by a line about the finished row.
  void finish(const std::string& line);

 private:
  void wipe();

  bool terminal_;
  std::chrono::steady_clock::time_point start_;
  std::chrono::steady_clock::time_point shown_;
  std::size_t width_ = 0;  // of the bar on the screen
};

}  // namespace limber::bench
