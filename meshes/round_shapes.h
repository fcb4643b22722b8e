// SPDX-License-Identifier: Zlib
#pragma once

#include "triangle_soup.h"

namespace shapes {

/// A ball of radius 0.5 m: an icosahedron with each triangle split into 16.
TriangleSoup makeIcosphere();

/// The icosphere with a spike at each corner of the icosahedron; the tips are 0.588 m from the centre.
TriangleSoup makeStar();

/// 16 segments around the y axis with 8 sides each, 1 m wide.
TriangleSoup makeTorus();

/// Along the y axis, 1 m high, with a fan of triangles at each end.
TriangleSoup makeCylinder();

}  // namespace shapes
