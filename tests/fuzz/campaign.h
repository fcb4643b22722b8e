// SPDX-License-Identifier: Zlib
#pragma once

#include "fuzz/laws.h"

#include <functional>
#include <vector>

namespace limber::fuzz {

/// What became of a story in a process of its own.
struct Verdict {
  std::string law;     ///< empty: all hold. "crash" and "time" besides the laws
  std::string detail;  ///< of a crash what the process wrote last

  bool failed() const { return !law.empty(); }
};

/// What a story is given.
struct Effort {
  int jobs = 1;           ///< processes at a time
  double seconds = 60.0;  ///< of a processor's time
  Lawbook laws;
};

/// Plays stories in child processes and calls `told` with each one's index and verdict as they end, here.
void judge(const std::vector<Story>& stories, const Effort& effort,
           const std::function<void(std::size_t, const Verdict&)>& told);
Verdict judge(const Story& story, const Effort& effort);

/// The smallest story that fails as this one does: steps are left out, frames cut, numbers made simple, as
/// long as the same law breaks.
Story shrink(const Story& story, const Verdict& verdict, const Effort& effort);

}  // namespace limber::fuzz
