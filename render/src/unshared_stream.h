// SPDX-License-Identifier: Zlib
#pragma once

#include <cstddef>
#include <vector>

#include "frame_passes.h"
#include "instance_table.h"
#include "shape_table.h"
#include "unshared_mesh.h"

namespace limber::render {

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
