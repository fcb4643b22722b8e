// SPDX-License-Identifier: Zlib
#pragma once

#include <chrono>
#include <cstdio>
#include <optional>
#include <string>

namespace limber::demo {

/// Shows the progress of a run: a bar with the remaining time on a terminal, else a line every 10 %.
class Progress {
 public:
  /// `label` names the work, or is empty.
  Progress(std::FILE* stream, bool terminal, std::string label = {});
  /// Ends the line of an incomplete bar, so that an error can be printed below it.
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// Shows that `done` of `total` steps are finished.
  void show(long long done, long long total);

 private:
  double secondsLeft(double share) const;
  void showBar(double share);
  void showLine(double share);

  std::FILE* stream_;
  bool terminal_;
  std::string label_;  // followed by a blank, or empty
  std::chrono::steady_clock::time_point start_;
  int shown_ = -1;  // last value shown: percent on a bar, tens of percent in lines
};

/// Returns the time since then, s.
double secondsSince(std::chrono::steady_clock::time_point start);

/// True if the stream is a terminal that can redraw a line.
bool isTerminal(std::FILE* stream);

/// "1 min 05 s", "42 s".
std::string durationText(double seconds);

/// "[#####---------------]".
std::string barText(double share, int width);

/// Progress of several stages: one bar for each, one below the other.
class StageProgress {
 public:
  /// Stages that end within `patience` seconds get no bar.
  StageProgress(std::FILE* stream, bool terminal, double patience)
      : stream_(stream), terminal_(terminal), patience_(patience) {}

  /// `done`: 0 to 1 of the stage. A new name, or a smaller value than before, starts a new stage.
  void show(const std::string& stage, double done);
  /// Completes the last bar, so that the next output starts on a new line.
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
  bool open_ = false;  // a bar is shown and not yet full
};

}  // namespace limber::demo
