// SPDX-License-Identifier: Zlib
#pragma once

#include "limber/render/shape_desc.h"

#include <cstdint>
#include <vector>

namespace limber::render {

/// A vertex as the shaders read it. The last three only serve tubes.
struct SurfaceVertex {
  std::uint32_t point = 0;
  float u = 0.0f, v = 0.0f;
  float fraction = 0.0f;  ///< Of the way from `point` to the next point.
  float out = 0.0f;       ///< Profile: radii away from the middle line,
  float along = 0.0f;     ///< and radii along it (the round ends).
};

struct SurfaceMesh {
  std::vector<SurfaceVertex> vertices;
  std::vector<std::uint32_t> indices;
};

/// The surface of a tube through `pointCount` points (at least 2): rings of `segments` quads,
/// several between two points, closed by half spheres. u runs around and v along, both 0 to 1.
SurfaceMesh makeTubeMesh(std::uint32_t pointCount, std::uint32_t segments);

/// Whether a full matrix takes less memory: 4 bytes for each place and point against 8 for each weight.
bool isDense(const Skin& skin, std::uint32_t pointCount);

/// #points x #places: the weight of point k on place p at k * #places + p.
std::vector<float> denseWeights(const Skin& skin, std::uint32_t pointCount);

/// 2 x #weights: point and the weight's bits, in the order of the skin.
std::vector<std::uint32_t> sparseWeights(const Skin& skin);

/// The triangles at every point (place, if there is a skin), as the other two of each in turn.
struct PointAdjacency {
  std::vector<std::uint32_t> offsets;  ///< #points + 1, into corners counted in pairs.
  std::vector<std::uint32_t> corners;  ///< 2 per corner: the next and the previous point.
};

/// `desc` must be valid. Vertices that share a point share its list, so seams stay smooth.
PointAdjacency makePointAdjacency(const ShapeDesc& desc);

}  // namespace limber::render
