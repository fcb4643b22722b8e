// SPDX-License-Identifier: Zlib
#pragma once

#include "triangle_soup.h"

namespace shapes {

/// An ogre, 1.8 m high, that stands on y = 0, looks along +z and carries a club. Forty loose pieces, closed
/// ones and open sheets, which overlap, touch or float near each other.
TriangleSoup makeOgre();

}  // namespace shapes
