// SPDX-License-Identifier: Zlib
#pragma once

#include "triangle_soup.h"

namespace shapes {

/// A teapot, 1 m from handle to spout, that stands on y = 0; its spout points along +x. Three open pieces,
/// which intersect each other or leave gaps: a body with a handle, open at the top; a spout, open at both
/// ends, that sticks in the body's wall; a lid that lies loosely in the opening, its knob wound the other way
/// round.
TriangleSoup makeTeapot();

}  // namespace shapes
