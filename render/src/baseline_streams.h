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

/// The simplest way to draw many bodies, as a reference for tests and benches: positions are written to plain
/// memory, then each instance is uploaded into its own buffer and has its own draw call.
class NaiveStream {
 public:
  explicit NaiveStream(const Gl& gl) : gl_(gl) {}

  /// Returns the memory for the points of the layout's instances.
  float* begin(const FrameLayout& layout);
  /// Uploads the points and fills `items`, one for each instance; `places` has the computed skins.
  void upload(const FrameLayout& layout, const ShapeTable& shapes, const GlBuffer& places,
              std::vector<DrawItem>& items);
  std::size_t bytes() const;

 private:
  GLuint bufferFor(std::size_t instance, std::size_t bytes);

  const Gl& gl_;
  std::vector<float> staging_;
  std::vector<GlBuffer> buffers_;
};

/// A vertex in the format of Bullet's example browser.
struct UnsharedVertex {
  Vec3 position;
  float w = 1.0f;
  Vec3 normal;
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

/// Reads the mesh back from the GPU, so that no copy is kept for other stream paths. Not for tubes.
UnsharedMesh readUnsharedMesh(const Gl& gl, const GpuShape& shape);

/// Computes vertices from points on the CPU; reuses its memory.
class UnsharedVertices {
 public:
  /// `points`: 3 floats for each point of the mesh. The result is valid until the next call.
  const std::vector<UnsharedVertex>& make(const UnsharedMesh& mesh, const float* points);

 private:
  void sumNormals(const UnsharedMesh& mesh, const float* points);

  std::vector<Vec3> normals_;  // one per point
  std::vector<UnsharedVertex> vertices_;
};

/// Draws bodies as Bullet's example browser draws its soft bodies, as a reference for benches. In every frame
/// the CPU computes three vertices with normals per triangle. Each body has its own vertices, indices and
/// vertex array, one upload, and one draw call per pass. It does less work than that browser, which sets
/// seven attributes and some uniforms for each draw and puts its bodies into one buffer.
class UnsharedStream {
 public:
  explicit UnsharedStream(const Gl& gl) : gl_(gl) {}

  /// Returns the memory for the points of the layout's instances. Throws std::runtime_error if one of them is
  /// a tube or has a skin.
  float* begin(const FrameLayout& layout, const ShapeTable& shapes);
  /// Uploads the vertices and fills `items`, one for each instance.
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
