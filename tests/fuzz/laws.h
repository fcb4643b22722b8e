// SPDX-License-Identifier: Zlib
#pragma once

#include "fuzz/player.h"

#include <optional>

namespace limber::fuzz {

/// The laws that are checked for a story.
struct Lawbook {
  bool once = false;     ///< the story is played once, without the laws that compare runs
  unsigned threads = 1;  ///< of the first run
  std::string beside;    ///< path of a limber_fuzz of another build, whose results for gentle stories must
                         ///< agree; empty: none
};

/// Plays a story, with all variants that its promise requires, and returns the first broken law.
std::optional<Failure> checkStory(const Story& story, const Lawbook& laws);

/// Checks the laws of invariance, for gentle stories: changes of the story that must not change the result.
/// `run` is the unchanged story's.
std::optional<Failure> checkInvariance(const Story& story, const Run& run, const Lawbook& laws);

/// Write and read the points of all frames. A file that cannot be read gives a run without frames.
void writeFrames(const Run& run, const std::string& path);
Run readFrames(const std::string& path);

/// Builds the networks of the story, which takes long, once for all child processes of this process.
void prepare(const Story& story);

}  // namespace limber::fuzz
