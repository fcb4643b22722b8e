// SPDX-License-Identifier: Zlib
#pragma once

#include "fuzz/story.h"

namespace limber::fuzz {

/// Returns the story of a seed. The promise of its world says which laws it must satisfy. wild: any actions,
/// but no crash and no explosion; closed: no source of energy; gentle: soft bodies on a floor, without a
/// user.
Story makeStory(std::uint64_t seed);

}  // namespace limber::fuzz
