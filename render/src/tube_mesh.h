// SPDX-License-Identifier: Zlib
#pragma once

#include "surface_mesh.h"

namespace limber::render {

/// The surface of a tube through `pointCount` points (at least 2): rings of `segments` quads,
/// several between two points, closed by half spheres. u runs around and v along, both 0 to 1.
SurfaceMesh makeTubeMesh(std::uint32_t pointCount, std::uint32_t segments);

}  // namespace limber::render
