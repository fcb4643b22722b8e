// SPDX-License-Identifier: Zlib
#pragma once

#include "instance_table.h"
#include "limber/render/gl_objects.h"
#include "limber/render/shape_desc.h"

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace limber::render {

/// The weights of a skin, in one of two layouts. Dense: weight of (place, point) at
/// point * placeCount + place, so that neighbouring invocations read neighbouring floats. Sparse: by
/// place, a point and its weight each.
struct GpuSkin {
  bool dense = false;
  GlBuffer first;  ///< Sparse only: placeCount + 1.
  GlBuffer weights;

  std::size_t bytes() const { return first.bytes() + weights.bytes(); }
};

/// The shared data of one shape on the GPU. Nothing in it changes after construction.
struct GpuShape {
  std::string name;
  std::uint32_t pointCount = 0;
  std::uint32_t placeCount = 0;  ///< Equals pointCount without a skin.
  bool tube = false;
  bool smooth = false;  ///< Always for tubes, if only because their frames are computed the same way.
  bool twoSided = false;
  bool castsShadow = true;
  bool grid = false;
  float radius = 0.0f;  ///< Of the tube or of the grid.

  GLsizei indexCount = 0;
  GLsizei lineCount = 0;
  GpuSkin skin;
  GlBuffer vertices;
  GlBuffer indices;
  GlBuffer lines;             ///< Two points and one over the rest length (0: none), 12 bytes each.
  GlBuffer adjacencyOffsets;  ///< Smooth meshes only, as are the corners.
  GlBuffer adjacencyCorners;
  GlVertexArray layout;
  GlBuffer weldedIndices;      ///< Points instead of vertices; empty where they are the same, and of tubes.
  GlVertexArray weldedLayout;  ///< For them; no attributes. Of meshes only.

  std::size_t bytes() const;
  bool skinned() const { return skin.weights.name() != 0; }
  /// Three floats per place are computed for it before anything is drawn.
  bool needsNormals() const { return smooth && (tube || indexCount > 0); }
};

/// Adds a vertex attribute of `floats` floats at `offset` bytes of a vertex, from vertex buffer 0 of the
/// layout.
void addFloatAttribute(const Gl& gl, GLuint layout, GLuint attribute, GLint floats, std::size_t offset);

/// Throws std::runtime_error with the shape's name if the description is not valid.
GpuShape makeGpuShape(const Gl& gl, const ShapeDesc& desc);

/// The living shapes. As with instances, ids of removed ones are refused though their slots are reused.
class ShapeTable {
 public:
  ShapeId add(GpuShape shape);
  /// The id must be good and the shape without instances.
  void remove(ShapeId id);
  /// Throws std::runtime_error naming `caller` unless the id is that of a living shape.
  void require(ShapeId id, const char* caller) const;

  const GpuShape& operator[](std::uint32_t index) const { return shapes_[index]; }
  /// Changes when another shape takes the index.
  std::uint32_t generation(std::uint32_t index) const { return generations_[index]; }
  /// By index; without points where there is no shape.
  const std::vector<ShapeExtent>& extents() const { return extents_; }
  std::size_t bytes() const;

 private:
  std::vector<GpuShape> shapes_;
  std::vector<ShapeExtent> extents_;
  std::vector<std::uint32_t> generations_;
  std::vector<std::uint32_t> free_;
};

}  // namespace limber::render
