// SPDX-License-Identifier: Zlib
#pragma once

#include "gpu_shape.h"

#include <limber/render/vec3.h>

#include <cstdint>
#include <vector>

namespace limber::bench {

/// A vertex in the format of Bullet's example browser.
struct UnsharedVertex {
  render::Vec3 position;
  float w = 1.0f;
  render::Vec3 normal;
  float u = 0.0f, v = 0.0f;
};
static_assert(sizeof(UnsharedVertex) == 36, "uploaded as it lies");

/// The triangles of a shape in plain memory, with three separate corners each.
struct UnsharedMesh {
  struct Corner {
    std::uint32_t point = 0;
    float u = 0.0f, v = 0.0f;
  };

  std::vector<Corner> corners;  ///< 3 per triangle.
  std::uint32_t pointCount = 0;
  bool smooth = false;
};

/// Reads the mesh back from the GPU, where the renderer has its only copy. Not for tubes.
UnsharedMesh readUnsharedMesh(const render::Gl& gl, const render::GpuShape& shape);

/// Computes vertices from points on the CPU; reuses its memory.
class UnsharedVertices {
 public:
  /// `points`: 3 floats for each point of the mesh. The result is valid until the next call.
  const std::vector<UnsharedVertex>& make(const UnsharedMesh& mesh, const float* points);

 private:
  void sumNormals(const UnsharedMesh& mesh, const float* points);

  std::vector<render::Vec3> normals_;  // One per point.
  std::vector<UnsharedVertex> vertices_;
};

}  // namespace limber::bench
