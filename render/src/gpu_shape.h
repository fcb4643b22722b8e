// SPDX-License-Identifier: Zlib
#pragma once

#include "cpu_passes.h"
#include "instance_table.h"
#include "limber/render/gl_objects.h"
#include "limber/render/shape_desc.h"

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace limber::render {

/// The weights of a skin, in one of two layouts. Dense: the weight of (place, point) is at point *
/// skinnedPointCount
/// + place, so that neighbouring invocations read neighbouring floats. Sparse: pairs of a point and its
/// weight, place by place.
struct GpuSkin {
  bool dense = false;
  GlBuffer first;  ///< Sparse only: skinnedPointCount + 1.
  GlBuffer weights;

  std::size_t bytes() const { return first.bytes() + weights.bytes(); }
};

/// What the CPU reads if it computes skins and normals; the GPU then has no skin and no adjacency.
struct CpuShape {
  CpuSkin skin;
  CpuTriangles triangles;  ///< Smooth meshes only.
};

/// The shared data of one shape. It does not change after construction.
struct GpuShape {
  std::string name;
  std::uint32_t pointCount = 0;
  std::uint32_t skinnedPointCount = 0;  ///< Equals pointCount without a skin.
  std::uint32_t normalCount = 0;
  bool sharp = false;  ///< Vertices of one point may have different normals.
  bool tube = false;
  bool smooth = false;  ///< Always true for tubes: their side vectors are computed like normals.
  bool twoSided = false;
  bool hideBackFaces = false;  ///< Always true unless two-sided.
  bool castsShadow = true;
  bool closed = false;  ///< See isClosed(); false for tubes.
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
  GlBuffer weldedIndices;      ///< Points instead of vertices; empty if these are equal, and for tubes.
  GlVertexArray weldedLayout;  ///< For weldedIndices, without attributes; meshes only.

  CpuShape cpu;

  /// Of buffers.
  std::size_t bytes() const;
  bool skinned() const { return skin.weights.name() != 0 || cpu.skin.placeCount != 0; }
  /// True if three floats per place are computed before drawing.
  bool needsNormals() const { return smooth && (tube || indexCount > 0); }
};

/// `computeOnCpu` decides where the skin's weights and the adjacency go. Throws std::runtime_error with the
/// shape's name if the description is not valid.
GpuShape makeGpuShape(const Gl& gl, const ShapeDesc& desc, bool computeOnCpu);

/// The existing shapes. Ids of removed shapes are rejected, although their slots are reused.
class ShapeTable {
 public:
  ShapeId add(GpuShape shape);
  /// Makes an id invalid, which must be valid, and its shape without instances. The shape itself stays for an
  /// open frame until freeRemoved().
  void remove(ShapeId id);
  void freeRemoved();
  /// Throws std::runtime_error with `caller` if there is no shape with this id.
  void require(ShapeId id, const char* caller) const;

  const GpuShape& operator[](std::uint32_t index) const { return shapes_[index]; }
  /// Extents by index; with 0 points where there is no shape.
  const std::vector<ShapeExtent>& extents() const { return extents_; }
  std::size_t bytes() const;

 private:
  std::vector<GpuShape> shapes_;
  std::vector<ShapeExtent> extents_;
  std::vector<std::uint32_t> generations_;
  std::vector<std::uint32_t> removed_, free_;
};

}  // namespace limber::render
