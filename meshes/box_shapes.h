// SPDX-License-Identifier: Zlib
#pragma once

#include "triangle_soup.h"

namespace shapes {

/// Edge length 1 m, centred at the origin; the picture once on each face.
TriangleSoup makeCube();

/// An L of 12 x 4 cubic cells of 0.25 m in a box of 1 m, its surface split into the faces of the cells.
TriangleSoup makeLShape();

}  // namespace shapes
