// SPDX-License-Identifier: Zlib
#pragma once

#include "fuzz/laws.h"

#include <functional>
#include <vector>

namespace limber::fuzz {

/// The result of a story played in its own process.
struct Verdict {
  std::string law;     ///< empty: all hold; "crash" and "time" besides the names of laws
  std::string detail;  ///< for a crash: the output of the process

  bool failed() const { return !law.empty(); }
};

/// Limits for playing stories.
struct Effort {
  int jobs = 1;           ///< number of processes at a time
  double seconds = 60.0;  ///< processor time of a story
  Lawbook laws;
};

/// Plays stories in child processes. Calls `report` in this process with the index and verdict of each story
/// as it ends.
void judge(const std::vector<Story>& stories, const Effort& effort,
           const std::function<void(std::size_t, const Verdict&)>& report);
Verdict judge(const Story& story, const Effort& effort);

/// Returns a smaller story that breaks the same law: with fewer steps and frames and simpler numbers.
Story shrink(const Story& story, const Verdict& verdict, const Effort& effort);

}  // namespace limber::fuzz
