// SPDX-License-Identifier: Zlib
#pragma once

#include "collide/surface_contacts.h"

namespace limber {

/// Keeps one of the candidates that push a vertex in the same direction, the one that comes first, and one of
/// those that push in the same direction at the same place. Sorted by key. Reorders the candidates.
void reduceContacts(std::vector<ContactCandidate>& candidates, std::vector<SurfaceContact>& found);

}  // namespace limber
