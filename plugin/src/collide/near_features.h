// SPDX-License-Identifier: Zlib
#pragma once

#include "collide/contact_candidates.h"

namespace limber {

/// What the features in the care of the elements of `search.near` have to do with each other; adds to
/// `search.candidates` and `search.behind`.
void meetNearFeatures(const SurfacePair& pair, ContactSearch& search);

}  // namespace limber
