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

/// Plays stories in child processes, `jobs` at a time, each for no more than `seconds` of processor time, and calls `told` with
/// each one's index and verdict as they end, here.
void judge(const std::vector<Story>& stories, int jobs, double seconds,
           const std::function<void(std::size_t, const Verdict&)>& told);
Verdict judge(const Story& story, double seconds);

/// The smallest story that fails as this one does: steps are left out, frames cut, numbers made simple, as
/// long as the same law breaks.
Story shrink(const Story& story, const Verdict& verdict, int jobs, double seconds);

}  // namespace limber::fuzz
