// SPDX-License-Identifier: Zlib
#pragma once

#include <chrono>
#include <cstdio>
#include <optional>
#include <string>

namespace limber::demo {

/// How far a run has come: a bar with the time left on a terminal, a plain line every 10 % elsewhere.
class Progress {
 public:
  /// `label` says what is under way, or is empty.
  Progress(std::FILE* stream, bool terminal, std::string label = {});
  /// Ends the line of a bar that has not filled up, so that the reason can be printed below it.
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// `done` of `total` steps are over.
  void show(long long done, long long total);

 private:
  double secondsLeft(double share) const;
  void showBar(double share);
  void showLine(double share);

  std::FILE* stream_;
  bool terminal_;
  std::string label_;  // with a blank behind it, or empty
  std::chrono::steady_clock::time_point start_;
  int shown_ = -1;  // what the reader sees: percent on a bar, tens of percent in lines
};

/// True if the stream is a terminal that can redraw a line.
bool isTerminal(std::FILE* stream);

/// "1 min 05 s", "42 s".
std::string durationText(double seconds);

/// "[#####---------------]".
std::string barText(double share, int width);

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
