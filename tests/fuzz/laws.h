// SPDX-License-Identifier: Zlib
#pragma once

#include "fuzz/player.h"

#include <optional>

namespace limber::fuzz {

/// Which laws a story is held to.
struct Lawbook {
  bool once = false;   ///< it is played once: the laws that compare runs are left out
  std::string beside;  ///< a limber_fuzz of another build, which must play gentle stories alike; empty: none
};

/// Plays a story in all the ways its promise asks for and tells the first law that does not hold.
std::optional<Failure> checkStory(const Story& story, const Lawbook& laws);

/// The laws of invariance, for gentle stories: what must not change the answer. `run` is the story as it is.
std::optional<Failure> checkInvariance(const Story& story, const Run& run, const Lawbook& laws);

/// The frames' points in a file, and from there; a run without frames if they cannot be read.
void writeFrames(const Run& run, const std::string& path);
Run readFrames(const std::string& path);

/// Makes what the story needs and what takes long, once for all children of this process.
void prepare(const Story& story);

}  // namespace limber::fuzz
