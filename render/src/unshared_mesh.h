// SPDX-License-Identifier: Zlib
#pragma once

#include <cstdint>
#include <vector>

#include "gpu_shape.h"
#include "limber/render/vec3.h"

namespace limber::render {

/// A vertex as Bullet's example browser uploads it.
struct UnsharedVertex {
  Vec3 position;
  float w = 1.0f;
  Vec3 normal;
  float u = 0.0f, v = 0.0f;
};
static_assert(sizeof(UnsharedVertex) == 36, "uploaded as it lies");

/// The triangles of a shape in plain memory, each with three corners of its own.
struct UnsharedMesh {
  struct Corner {
    std::uint32_t point = 0;
    float u = 0.0f, v = 0.0f;
  };

  std::vector<Corner> corners;  ///< 3 per triangle.
  std::uint32_t pointCount = 0;
  bool smooth = false;
};

/// Read back from the GPU, so that a renderer that never needs it keeps no copy. Not for tubes.
UnsharedMesh readUnsharedMesh(const Gl& gl, const GpuShape& shape);

/// Makes vertices from points on the CPU; keeps its memory between calls.
class UnsharedVertices {
 public:
  /// `points`: 3 floats for each point of the mesh. The result lasts until the next call.
  const std::vector<UnsharedVertex>& make(const UnsharedMesh& mesh, const float* points);

 private:
  void sumNormals(const UnsharedMesh& mesh, const float* points);

  std::vector<Vec3> normals_;  // one per point
  std::vector<UnsharedVertex> vertices_;
};

}  // namespace limber::render
