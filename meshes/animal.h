// SPDX-License-Identifier: Zlib
#pragma once

#include "triangle_soup.h"

namespace shapes {

/// A cow, 1 m long, that stands on y = 0 and looks along +z: thin legs, horns, ears, a tail and an udder. One
/// closed piece.
TriangleSoup makeAnimal();

}  // namespace shapes
