// SPDX-License-Identifier: Zlib
#pragma once

#include "triangle_soup.h"

namespace shapes {

/// A sitting rabbit as a scanner would see it, in decimetres: 1.6 high, on y = 0, looks along +z. The surface
/// is bumpy, the points are noisy and irregular, and about 200 open edges surround the places that the
/// scanner did not see: two holes in the base, under the chin, between the ears, beside the hind legs.
TriangleSoup makeBunny();

}  // namespace shapes
