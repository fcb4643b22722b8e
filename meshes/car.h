// SPDX-License-Identifier: Zlib
#pragma once

#include "triangle_soup.h"

namespace shapes {

/// A round car, 4 m long, that stands on y = 0 and drives along +z. Its body consists of open sheets without
/// thickness: shell, roof, doors, bonnet, engine lid, fenders, floor, bumpers. They meet at gaps or cross
/// each other; the windows are holes. The wheels and lamps are closed.
TriangleSoup makeCar();

}  // namespace shapes
