// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/triangle_mesh.h>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace limber {

/// Which pieces of a surface share no point.
struct SurfaceComponents {
  std::size_t count = 0;
  std::vector<std::uint32_t> ofTriangle;  ///< #triangles, numbered in the order of their first triangles
};

SurfaceComponents findComponents(std::size_t points, const std::vector<Triangle>& triangles);

}  // namespace limber
