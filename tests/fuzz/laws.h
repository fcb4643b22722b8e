// SPDX-License-Identifier: Zlib
#pragma once

#include "fuzz/player.h"

#include <optional>

namespace limber::fuzz {

/// Plays a story in all the ways its promise asks for, or `once`, and tells the first law that does not hold.
std::optional<Failure> checkStory(const Story& story, bool once);

/// The laws of invariance, for gentle stories: what must not change the answer. `run` is the story as it is.
std::optional<Failure> checkInvariance(const Story& story, const Run& run);

/// Makes what the story needs and what takes long, once for all children of this process.
void prepare(const Story& story);

}  // namespace limber::fuzz
