// SPDX-License-Identifier: Zlib
#pragma once

#include "collide/contact_candidates.h"

namespace limber {

/// Finds out which vertices of `search.behind` are inside the other surface, and adds a contact for each:
/// with the nearest triangle that the vertex faces.
void addInsideVertices(const SurfacePair& pair, ContactSearch& search);

}  // namespace limber
