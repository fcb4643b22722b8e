// SPDX-License-Identifier: Zlib
#pragma once

#include "fuzz/story.h"

namespace limber::fuzz {

/// The story of a seed. Its world's promise says which laws it has to keep:
/// wild: anything goes, but nothing breaks; closed: no source of energy; gentle: soft bodies on a floor,
/// without a user.
Story makeStory(std::uint64_t seed);

}  // namespace limber::fuzz
