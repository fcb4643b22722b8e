// SPDX-License-Identifier: Zlib
#pragma once

#include "frame_passes.h"
#include "gpu_shape.h"
#include "instance_table.h"
#include "limber/render/vec3.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace limber::render {

/// The obvious way to draw many bodies, kept to measure and to check the real one against: positions
/// are written to plain memory, then each instance is uploaded into a buffer of its own and drawn by
/// itself.
class NaiveStream {
 public:
  explicit NaiveStream(const Gl& gl) : gl_(gl) {}

  /// Where the points of the layout's instances are to be written.
  float* begin(const FrameLayout& layout);
  /// Uploads them and fills `items`, one for each instance; `places` is where skins are computed.
  void upload(const FrameLayout& layout, const ShapeTable& shapes, const GlBuffer& places,
              std::vector<DrawItem>& items);
  std::size_t bytes() const;

 private:
  GLuint bufferFor(std::size_t instance, std::size_t bytes);

  const Gl& gl_;
  std::vector<float> staging_;
  std::vector<GlBuffer> buffers_;
};

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

/// Bodies drawn as Bullet's example browser draws its soft bodies, kept to measure the real path against:
/// every frame three vertices per triangle are made on the CPU, normals and all, and each body has
/// vertices, indices and a vertex array of its own, one upload, and one draw per pass. Kinder than that
/// browser, which sets seven attributes and some uniforms anew for each draw; its bodies share one buffer.
class UnsharedStream {
 public:
  explicit UnsharedStream(const Gl& gl) : gl_(gl) {}

  /// Where the points of the layout's instances are to be written. Throws std::runtime_error if one of
  /// them is a tube or has a skin.
  float* begin(const FrameLayout& layout, const ShapeTable& shapes);
  /// Uploads their vertices and fills `items`, one for each instance.
  void upload(const FrameLayout& layout, const ShapeTable& shapes, std::vector<DrawItem>& items);
  std::size_t uploadedBytes() const { return uploadedBytes_; }  ///< By the last upload().
  std::size_t bytes() const;

 private:
  struct Body {
    GlBuffer vertices;
    GlBuffer indices;
    GlVertexArray layout;
  };

  struct ShapeMesh {
    bool read = false;
    std::uint32_t generation = 0;
    UnsharedMesh mesh;
  };

  const UnsharedMesh& meshOf(std::uint32_t shape, const ShapeTable& shapes);
  GLuint uploadBody(std::size_t instance, const std::vector<UnsharedVertex>& vertices);

  const Gl& gl_;
  std::vector<float> staging_;
  std::vector<ShapeMesh> meshes_;  // By shape, read when first drawn.
  UnsharedVertices maker_;
  std::vector<Body> bodies_;
  std::size_t uploadedBytes_ = 0;
};

}  // namespace limber::render
