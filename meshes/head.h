// SPDX-License-Identifier: Zlib
#pragma once

#include "triangle_soup.h"

namespace shapes {

/// The head of a monkey, 1 m wide, that looks along +z. Its skin has holes at the eyes, the mouth and the
/// neck; the eyeballs are separate closed balls behind the holes.
TriangleSoup makeHead();

}  // namespace shapes
