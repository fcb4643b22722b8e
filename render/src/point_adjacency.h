// SPDX-License-Identifier: Zlib
#pragma once

#include <cstdint>
#include <vector>

#include "limber/render/shape_desc.h"

namespace limber::render {

/// The triangles at every point (place, if there is a skin), as the other two of each in turn.
struct PointAdjacency {
  std::vector<std::uint32_t> offsets;  ///< #points + 1, into corners counted in pairs.
  std::vector<std::uint32_t> corners;  ///< 2 per corner: the next and the previous point.
};

/// `desc` must be valid. Vertices that share a point share its list, so seams stay smooth.
PointAdjacency makePointAdjacency(const ShapeDesc& desc);

}  // namespace limber::render
