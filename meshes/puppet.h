// SPDX-License-Identifier: Zlib
#pragma once

#include "triangle_soup.h"

namespace shapes {

/// A gingerbread man, 1 m high, that stands on y = 0 and looks along +z: one flat sheet without thickness in
/// the plane z = 0, with holes for eyes, mouth and buttons.
TriangleSoup makePuppet();

}  // namespace shapes
