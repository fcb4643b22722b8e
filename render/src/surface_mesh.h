// SPDX-License-Identifier: Zlib
#pragma once

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

}  // namespace limber::render
