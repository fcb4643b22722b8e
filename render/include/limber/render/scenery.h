// SPDX-License-Identifier: Zlib
#pragma once

#include "limber/render/shape_desc.h"
#include "limber/render/vec3.h"

#include <cstdint>
#include <vector>

namespace limber::render {

/// A shape and its points at rest; y is up. For a shape that does not move, write these points in every
/// frame.
struct Scenery {
  ShapeDesc shape;
  std::vector<float> points;  ///< 3 x shape.pointCount, metres.
};

/// 8 points, 24 vertices (each face has its own uv square), 12 triangles, flat.
Scenery makeBox(Vec3 centre, Vec3 halfExtents);

/// Smooth; `rings` bands from pole to pole (at least 2), `segments` around (at least 3).
Scenery makeUvSphere(Vec3 centre, float radius, std::uint32_t rings = 24, std::uint32_t segments = 48);

/// A horizontal quad facing up, with the grid pattern (1 metre cells) fading out at `halfSize`. `extent`:
/// half its sides, if they are longer. With Quality::Gallery the floor ends at the horizon, or with the quad.
Scenery makeFloor(Vec3 centre, float halfSize, float extent = 0.0f);

}  // namespace limber::render
