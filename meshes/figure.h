// SPDX-License-Identifier: Zlib
#pragma once

#include "triangle_soup.h"

namespace shapes {

/// A standing figure, 1 m high, with arms, legs and ears, that looks along +z. The picture is projected from
/// the front.
TriangleSoup makeFigure();

}  // namespace shapes
