// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/mesh.h>

#include <vector>

namespace limber::bench {

/// Returns the outer triangles of side x side x side points in the order of latticeNetwork(), facing outward.
/// `side` is at least 2.
std::vector<Triangle> boxSurface(int side);

}  // namespace limber::bench
